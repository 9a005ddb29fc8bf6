#include "worker/io/glb_writer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <meshoptimizer.h>

#include "schemas/error.hpp"
#include "worker/io/glb_document.hpp"
#include "worker/io/gltf.hpp"
#include "worker/io/jpeg.hpp"
#include "worker/io/mesh_check.hpp"
#include "worker/io/mesh_part.hpp"
#include "worker/io/position_lattice.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

using LinearColor = std::array<std::uint16_t, 4>;

// Converts by IEC 61966-2-1.
std::uint16_t linear_from_srgb(std::uint8_t srgb) {
    const double s = srgb / 255.0;
    const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    return static_cast<std::uint16_t>(std::lround(linear * 65535.0));
}

std::array<std::uint16_t, 256> linear_table() {
    std::array<std::uint16_t, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = linear_from_srgb(static_cast<std::uint8_t>(i));
    return table;
}

// Adds the least and the greatest value of each component, which glTF requires of positions.
template <typename Value, std::size_t kSize>
void state_bounds(const std::vector<std::array<Value, kSize>>& values, json& accessor) {
    for (std::size_t i = 0; i < 3; ++i) {
        const auto [low, high] =
            std::minmax_element(values.begin(), values.end(), [i](const auto& a, const auto& b) {
                return a[i] < b[i];
            });
        accessor["min"].push_back((*low)[i]);
        accessor["max"].push_back((*high)[i]);
    }
}

// Puts the vertices into the order that graphics cards draw fastest and that compresses best.
// Returns the corners of the triangles in theirs.
std::vector<std::uint32_t> sort_for_drawing(MeshPart& part) {
    const std::size_t num_vertices = part.mesh_vertex.size();
    std::vector<std::uint32_t> corners(3 * part.triangles.size());
    meshopt_optimizeVertexCache(
        corners.data(), part.triangles.front().data(), corners.size(), num_vertices);
    std::vector<unsigned> order(num_vertices);
    meshopt_optimizeVertexFetchRemap(order.data(), corners.data(), corners.size(), num_vertices);
    const MeshPart before = part;
    for (std::size_t i = 0; i < num_vertices; ++i) {
        part.mesh_vertex[order[i]] = before.mesh_vertex[i];
        if (!part.uv.empty()) part.uv[order[i]] = before.uv[i];
    }
    for (std::uint32_t& corner : corners) corner = order[corner];
    return corners;
}

class GlbWriter {
public:
    GlbWriter(GlbFile& file,
              const types::Mesh& mesh,
              const types::Texture* texture,
              GlbCompression compression)
        : mesh_(mesh),
          texture_(texture),
          is_quantised_(compression != GlbCompression::None),
          normals_(unit_normals(mesh)),
          lattice_(position_lattice(mesh)),
          document_(file, compression) {}

    json write() {
        const auto num_atlases = texture_ == nullptr ? 0 : std::ssize(texture_->atlases);
        for (std::int32_t atlas = 0; atlas < num_atlases; ++atlas) add_part(atlas);
        add_part(types::Texture::kUntextured);
        json document = document_.finish(primitives_, node());
        if (is_quantised_)
            document["asset"]["extras"] = {{"max_position_error_m", lattice_.max_error_m()}};
        return document;
    }

private:
    void add_part(std::int32_t atlas) {
        MeshPart part = mesh_part(mesh_, texture_, atlas);
        if (part.triangles.empty()) return;
        const std::vector<std::uint32_t> corners = sort_for_drawing(part);
        json primitive = {{"mode", kGltfTriangles}};
        json& attributes = primitive["attributes"];
        attributes["POSITION"] = is_quantised_ ? add_lattice_points(part) : add_positions(part);
        attributes["NORMAL"] = is_quantised_ ? add_byte_normals(part) : add_normals(part);
        if (!part.uv.empty())
            attributes["TEXCOORD_0"] = is_quantised_ ? add_short_uv(part) : add_uv(part);
        else if (!mesh_.colors.empty())
            attributes["COLOR_0"] = add_colors(part);
        primitive["indices"] = document_.add_triangles(corners, part.mesh_vertex.size());
        primitive["material"] = atlas == types::Texture::kUntextured
                                    ? document_.add_material()
                                    : document_.add_material(encode_jpeg(
                                          texture_->atlases[static_cast<std::size_t>(atlas)]));
        primitives_.push_back(std::move(primitive));
    }

    int add_positions(const MeshPart& part) {
        std::vector<std::array<float, 3>> values;
        values.reserve(part.mesh_vertex.size());
        for (const std::uint32_t vertex : part.mesh_vertex) {
            const Eigen::Vector3f& p = mesh_.vertices[vertex];
            values.push_back({p.x(), p.y(), p.z()});
        }
        json accessor = {{"componentType", kGltfFloat}, {"type", "VEC3"}};
        state_bounds(values, accessor);
        return document_.add_attribute(values, std::move(accessor));
    }

    int add_lattice_points(const MeshPart& part) {
        std::vector<std::array<std::uint16_t, 4>> values;
        values.reserve(part.mesh_vertex.size());
        for (const std::uint32_t vertex : part.mesh_vertex) {
            const auto steps = lattice_.nearest(mesh_.vertices[vertex]);
            values.push_back({steps[0], steps[1], steps[2], 0});
        }
        json accessor = {{"componentType", kGltfUnsignedShort}, {"type", "VEC3"}};
        state_bounds(values, accessor);
        return document_.add_attribute(values, std::move(accessor));
    }

    int add_normals(const MeshPart& part) {
        std::vector<Eigen::Vector3f> values;
        values.reserve(part.mesh_vertex.size());
        for (const std::uint32_t vertex : part.mesh_vertex) values.push_back(normals_[vertex]);
        return document_.add_attribute(values, {{"componentType", kGltfFloat}, {"type", "VEC3"}});
    }

    int add_byte_normals(const MeshPart& part) {
        std::vector<std::array<std::int8_t, 4>> values;
        values.reserve(part.mesh_vertex.size());
        for (const std::uint32_t vertex : part.mesh_vertex) {
            auto& value = values.emplace_back();
            for (std::size_t i = 0; i < 3; ++i)
                value[i] = static_cast<std::int8_t>(
                    std::lround(127.0F * normals_[vertex][static_cast<Eigen::Index>(i)]));
        }
        return document_.add_attribute(
            values, {{"componentType", kGltfByte}, {"normalized", true}, {"type", "VEC3"}});
    }

    int add_uv(const MeshPart& part) {
        return document_.add_attribute(part.uv, {{"componentType", kGltfFloat}, {"type", "VEC2"}});
    }

    int add_short_uv(const MeshPart& part) {
        std::vector<std::array<std::uint16_t, 2>> values;
        values.reserve(part.uv.size());
        for (const Eigen::Vector2f& uv : part.uv)
            values.push_back({static_cast<std::uint16_t>(std::lround(65535.0F * uv.x())),
                              static_cast<std::uint16_t>(std::lround(65535.0F * uv.y()))});
        return document_.add_attribute(
            values,
            {{"componentType", kGltfUnsignedShort}, {"normalized", true}, {"type", "VEC2"}});
    }

    int add_colors(const MeshPart& part) {
        static const std::array<std::uint16_t, 256> table = linear_table();
        std::vector<LinearColor> values;
        values.reserve(part.mesh_vertex.size());
        for (const std::uint32_t vertex : part.mesh_vertex) {
            const types::Color& color = mesh_.colors[vertex];
            values.push_back({table[color[0]], table[color[1]], table[color[2]], 65535});
        }
        return document_.add_attribute(
            values,
            {{"componentType", kGltfUnsignedShort}, {"normalized", true}, {"type", "VEC4"}});
    }

    json node() const {
        const double half = std::sqrt(0.5);
        json node = {{"name", "z_up_to_y_up"}, {"mesh", 0}, {"rotation", {-half, 0.0, 0.0, half}}};
        if (!is_quantised_) return node;
        // The rotation turns (x, y, z) into (x, z, -y).
        node["translation"] = {lattice_.low_m.x(), lattice_.low_m.z(), -lattice_.low_m.y()};
        node["scale"] = {lattice_.step_m, lattice_.step_m, lattice_.step_m};
        return node;
    }

    const types::Mesh& mesh_;
    const types::Texture* texture_;
    bool is_quantised_;
    std::vector<Eigen::Vector3f> normals_;
    PositionLattice lattice_;
    GlbDocument document_;
    json primitives_ = json::array();
};

}  // namespace

void write_glb(const std::filesystem::path& file,
               const types::Mesh& mesh,
               const types::Texture* texture,
               GlbCompression compression) {
    check_mesh(mesh);
    if (texture != nullptr) check_texture(mesh, *texture);
    if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max() / 3)
        throw Error(ErrorCode::TooLarge,
                    "the mesh has more triangles than glTF can number: choose a larger voxel");
    GlbFile output(file);
    output.commit(GlbWriter(output, mesh, texture, compression).write());
}

}  // namespace divemesh::io
