#include "worker/io/glb_appearance.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

namespace divemesh::io {
namespace {

using nlohmann::json;

constexpr types::Color kWhite = {255, 255, 255};  // of vertices without a colour

// Converts by IEC 61966-2-1.
std::uint8_t srgb_from_linear(double linear) {
    const double value = std::clamp(linear, 0.0, 1.0);
    const double srgb =
        value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255.0 * srgb));
}

class AppearanceReader {
public:
    AppearanceReader(const json& document,
                     GlbBuffers& buffers,
                     const std::string& name,
                     TexturedMesh& textured)
        : document_(document), buffers_(buffers), name_(name), textured_(textured) {
        textured.texture.atlas_of_triangle.assign(textured.mesh.triangles.size(),
                                                  types::TextureMap::kUntextured);
        textured.texture.uv.resize(textured.mesh.triangles.size());
        for (auto& corners : textured.texture.uv) corners.fill(Eigen::Vector2f::Zero());
    }

    void add(const GlbPrimitive& primitive) {
        const json& attributes = primitive.description->at("attributes");
        if (attributes.contains("NORMAL")) add_normals(primitive, attributes["NORMAL"]);
        if (attributes.contains("COLOR_0")) add_colors(primitive, attributes["COLOR_0"]);
        const std::int32_t atlas = atlas_of(*primitive.description);
        if (atlas == types::TextureMap::kUntextured) return;
        if (!attributes.contains("TEXCOORD_0"))
            fail_glb(name_, "a textured primitive has no texture coordinates");
        add_uv(primitive, attributes["TEXCOORD_0"], atlas);
    }

private:
    AccessorValues values_of(const GlbPrimitive& primitive,
                             const json& accessor,
                             std::string_view type,
                             std::size_t num_components) {
        const AccessorValues values =
            buffers_.values_of(accessor.get<std::int64_t>(), type, num_components);
        if (values.count != primitive.num_vertices)
            fail_glb(name_, "an attribute has more or fewer values than there are positions");
        return values;
    }

    void add_normals(const GlbPrimitive& primitive, const json& accessor) {
        const AccessorValues values = values_of(primitive, accessor, "VEC3", 3);
        auto& normals = textured_.mesh.normals;
        normals.resize(textured_.mesh.vertices.size(), Eigen::Vector3f::UnitZ());
        const Eigen::Matrix3d A = primitive.A_world_node.inverse().transpose();
        for (std::size_t i = 0; i < values.count; ++i) {
            const Eigen::Vector3d stored(
                values.component(i, 0), values.component(i, 1), values.component(i, 2));
            const Eigen::Vector3d normal = A * stored;
            if (normal.allFinite() && normal.norm() > 0.0)
                normals[primitive.first_vertex + i] = normal.normalized().cast<float>();
        }
    }

    void add_colors(const GlbPrimitive& primitive, const json& accessor) {
        const AccessorValues values = values_of(primitive, accessor, "VEC4", 4);
        auto& colors = textured_.mesh.colors;
        colors.resize(textured_.mesh.vertices.size(), kWhite);
        for (std::size_t i = 0; i < values.count; ++i)
            for (std::size_t channel = 0; channel < 3; ++channel)
                colors[primitive.first_vertex + i][channel] =
                    srgb_from_linear(values.component(i, channel));
    }

    void add_uv(const GlbPrimitive& primitive, const json& accessor, std::int32_t atlas) {
        const AccessorValues values = values_of(primitive, accessor, "VEC2", 2);
        StoredTexture& texture = textured_.texture;
        const std::size_t end = primitive.first_triangle + primitive.num_triangles;
        for (std::size_t i = primitive.first_triangle; i < end; ++i) {
            texture.atlas_of_triangle[i] = atlas;
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const std::size_t vertex =
                    textured_.mesh.triangles[i][corner] - primitive.first_vertex;
                texture.uv[i][corner] =
                    Eigen::Vector2d(values.component(vertex, 0), values.component(vertex, 1))
                        .cast<float>();
            }
        }
    }

    // Returns the atlas of a primitive's material; kUntextured if it has none.
    std::int32_t atlas_of(const json& primitive) {
        if (!primitive.contains("material")) return types::TextureMap::kUntextured;
        const json& material =
            glb_entry(document_, "materials", primitive["material"].get<int>(), name_);
        const json::json_pointer pointer("/pbrMetallicRoughness/baseColorTexture/index");
        if (!material.contains(pointer)) return types::TextureMap::kUntextured;
        const json& texture =
            glb_entry(document_, "textures", material.at(pointer).get<int>(), name_);
        const int image_index = texture.at("source").get<int>();
        const auto [found, is_new] = atlas_of_image_.try_emplace(
            image_index, static_cast<std::int32_t>(textured_.texture.jpegs.size()));
        if (is_new) {
            const json& image = glb_entry(document_, "images", image_index, name_);
            if (image.value("mimeType", "") != "image/jpeg" || !image.contains("bufferView"))
                fail_glb(name_, "a texture is not a JPEG in the file");
            textured_.texture.jpegs.emplace_back(
                buffers_.bytes_of_view(image["bufferView"].get<std::int64_t>()));
        }
        return found->second;
    }

    const json& document_;
    GlbBuffers& buffers_;
    const std::string& name_;
    TexturedMesh& textured_;
    std::map<int, std::int32_t> atlas_of_image_;
};

}  // namespace

void add_appearance(const json& document,
                    GlbBuffers& buffers,
                    const std::vector<GlbPrimitive>& primitives,
                    const std::string& name,
                    TexturedMesh& textured) {
    AppearanceReader reader(document, buffers, name, textured);
    for (const GlbPrimitive& primitive : primitives) reader.add(primitive);
}

}  // namespace divemesh::io
