#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/error.hpp"
#include "worker/io/glb_appearance.hpp"
#include "worker/io/glb_buffers.hpp"
#include "worker/io/gltf.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/weld_vertices.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little);

constexpr int kPoints = 0;     // mode of a primitive
constexpr int kMaxDepth = 64;  // of nested nodes

std::uint32_t word_at(std::string_view bytes, std::size_t offset) {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + offset, sizeof word);
    return word;
}

class GlbReader {
public:
    explicit GlbReader(const std::string& name) : name_(name) {}

    types::Mesh read(std::string_view bytes) {
        read_geometry(bytes);
        return std::move(mesh_);
    }

    TexturedMesh read_textured(std::string_view bytes) try {
        read_geometry(bytes);
        TexturedMesh textured{std::move(mesh_), {}};
        add_appearance(document_, *buffers_, primitives_, name_, textured);
        return textured;
    } catch (const json::exception&) {
        fail("its JSON is not glTF 2.0");
    }

private:
    void read_geometry(std::string_view bytes) try {
        split(bytes);
        const json& scene = glb_entry(document_, "scenes", document_.value("scene", 0), name_);
        const Eigen::Affine3d z_up(Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitX()));
        buffers_.emplace(document_, buffer_, name_);
        for (const json& node : scene.value("nodes", json::array()))
            add_node(node.get<int>(), z_up, 0);
        if (mesh_.vertices.empty()) fail("its scene has no positions");
    } catch (const json::exception&) {
        fail("its JSON is not glTF 2.0");
    }

    [[noreturn]] void fail(const std::string& what) const { fail_glb(name_, what); }

    // Header, JSON chunk, binary chunk (glTF 2.0, section 4.4).
    void split(std::string_view bytes) {
        if (bytes.size() < 20 || bytes.substr(0, 4) != "glTF" || word_at(bytes, 4) != 2)
            fail("it has no glTF 2 header");
        const std::size_t json_bytes = word_at(bytes, 12);
        if (word_at(bytes, 16) != 0x4E4F534AU || json_bytes > bytes.size() - 20)
            fail("its JSON is incomplete");
        document_ = json::parse(bytes.substr(20, json_bytes));
        const std::string_view rest = bytes.substr(20 + json_bytes);
        if (rest.size() < 8) return;
        const std::size_t buffer_bytes = word_at(rest, 0);
        if (word_at(rest, 4) != 0x004E4942U || buffer_bytes > rest.size() - 8)
            fail("its buffer is incomplete");
        buffer_ = rest.substr(8, buffer_bytes);
    }

    void add_node(int index, const Eigen::Affine3d& T_scene_parent, int depth) {
        if (depth > kMaxDepth) fail("its nodes are nested too deeply");
        const json& node = glb_entry(document_, "nodes", index, name_);
        visited_.resize(document_.at("nodes").size(), false);
        if (visited_[static_cast<std::size_t>(index)]) fail("a node has two parents");
        visited_[static_cast<std::size_t>(index)] = true;
        const Eigen::Affine3d T_scene_node = T_scene_parent * transform_of(node);
        if (node.contains("mesh")) add_mesh(node["mesh"].get<int>(), T_scene_node);
        for (const json& child : node.value("children", json::array()))
            add_node(child.get<int>(), T_scene_node, depth + 1);
    }

    static Eigen::Affine3d transform_of(const json& node) {
        Eigen::Affine3d T = Eigen::Affine3d::Identity();
        if (node.contains("matrix")) {
            const auto m = node["matrix"].get<std::array<double, 16>>();
            T.matrix() = Eigen::Map<const Eigen::Matrix4d>(m.data());
            return T;
        }
        const auto t = node.value("translation", std::array<double, 3>{0.0, 0.0, 0.0});
        const auto q = node.value("rotation", std::array<double, 4>{0.0, 0.0, 0.0, 1.0});
        const auto s = node.value("scale", std::array<double, 3>{1.0, 1.0, 1.0});
        return T.translate(Eigen::Vector3d(t[0], t[1], t[2]))
            .rotate(Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized())
            .scale(Eigen::Vector3d(s[0], s[1], s[2]));
    }

    void add_mesh(int index, const Eigen::Affine3d& T_scene_node) {
        for (const json& primitive :
             glb_entry(document_, "meshes", index, name_).at("primitives")) {
            const int mode = primitive.value("mode", kGltfTriangles);
            if (mode != kGltfTriangles && mode != kPoints) continue;
            const auto first = mesh_.vertices.size();
            const auto first_triangle = mesh_.triangles.size();
            const AccessorValues positions = buffers_->values_of(
                primitive.at("attributes").at("POSITION").get<int>(), "VEC3", 3);
            if (positions.count > max_entries() - first) fail("it shows its meshes too often");
            for (std::size_t i = 0; i < positions.count; ++i) {
                const Eigen::Vector3d stored(positions.component(i, 0),
                                             positions.component(i, 1),
                                             positions.component(i, 2));
                const Eigen::Vector3f p = (T_scene_node * stored).cast<float>();
                if (!p.allFinite()) fail("a position is not finite");
                mesh_.vertices.push_back(p);
            }
            if (mode == kGltfTriangles) add_triangles(primitive, first, positions.count);
            primitives_.push_back({&primitive,
                                   T_scene_node.linear(),
                                   first,
                                   positions.count,
                                   first_triangle,
                                   mesh_.triangles.size() - first_triangle});
        }
    }

    void add_triangles(const json& primitive, std::size_t first, std::size_t num_vertices) {
        std::vector<std::uint32_t> corners;
        if (primitive.contains("indices")) {
            const AccessorValues indices =
                buffers_->values_of(primitive["indices"].get<int>(), "SCALAR", 1);
            if (indices.component_type != kGltfUnsignedByte &&
                indices.component_type != kGltfUnsignedShort &&
                indices.component_type != kGltfUnsignedInt)
                fail("indices are not unsigned integers");
            if (indices.count / 3 > max_entries() - mesh_.triangles.size())
                fail("it shows its meshes too often");
            for (std::size_t i = 0; i < indices.count; ++i) {
                const std::uint32_t corner = indices.integer(i);
                if (corner >= num_vertices)
                    fail("a triangle refers to a vertex that does not exist");
                corners.push_back(corner);
            }
        } else {
            for (std::uint32_t i = 0; i < num_vertices; ++i) corners.push_back(i);
        }
        if (corners.size() / 3 > max_entries() - mesh_.triangles.size())
            fail("it shows its meshes too often");
        const auto base = static_cast<std::uint32_t>(first);
        for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
            mesh_.triangles.push_back(
                {base + corners[i], base + corners[i + 1], base + corners[i + 2]});
    }

    // Limits the output to a small multiple of the file size, as many nodes may show the same mesh.
    std::size_t max_entries() const { return std::min<std::size_t>(buffer_.size(), 1U << 31); }

    const std::string& name_;
    json document_;
    std::string_view buffer_;
    std::optional<GlbBuffers> buffers_;
    std::vector<bool> visited_;  // nodes
    types::Mesh mesh_;
    std::vector<GlbPrimitive> primitives_;
};

std::string read_bytes(const std::filesystem::path& file) {
    constexpr std::uintmax_t kMax_bytes = std::uintmax_t{4} << 30;
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw Error(ErrorCode::NotFound, "cannot open " + file.string() + ": check the path");
    if (std::filesystem::file_size(file) > kMax_bytes)
        throw Error(ErrorCode::TooLarge, file.string() + " is larger than 4 GiB: simplify it");
    return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

types::Mesh parse_glb(std::string_view bytes, const std::string& name) {
    return GlbReader(name).read(bytes);
}

TexturedMesh parse_textured_glb(std::string_view bytes, const std::string& name) {
    TexturedMesh textured = GlbReader(name).read_textured(bytes);
    weld_vertices(textured.mesh);
    return textured;
}

TexturedMesh read_textured_glb(const std::filesystem::path& file) {
    return parse_textured_glb(read_bytes(file), file.filename().string());
}

types::Mesh read_mesh(const std::filesystem::path& file) {
    const std::string bytes = read_bytes(file);
    const std::string name = file.filename().string();
    if (bytes.starts_with("ply")) return parse_ply(bytes, name);
    if (bytes.starts_with("glTF")) return parse_glb(bytes, name);
    return parse_obj(bytes, name);
}

}  // namespace divemesh::io
