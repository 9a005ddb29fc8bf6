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
#include <string>
#include <vector>

#include "schemas/error.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/io/ply.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little);

constexpr int kUnsignedByte = 5121;  // glTF component types
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kPoints = 0;  // modes
constexpr int kTriangles = 4;
constexpr int kMaxDepth = 64;  // of nested nodes

std::uint32_t word_at(std::string_view bytes, std::size_t offset) {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + offset, sizeof word);
    return word;
}

// Values of an accessor, checked to be inside the buffer.
struct Span {
    const char* data = nullptr;
    std::size_t count = 0;
    std::size_t stride_bytes = 0;
    int component_type = 0;
};

class GlbReader {
public:
    explicit GlbReader(const std::string& name) : name_(name) {}

    types::Mesh read(std::string_view bytes) try {
        split(bytes);
        const auto& scenes = member("scenes");
        const json& scene = entry(scenes, document_.value("scene", 0), "scene");
        const Eigen::Affine3d z_up(Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitX()));
        for (const json& node : scene.value("nodes", json::array()))
            add_node(node.get<int>(), z_up, 0);
        if (mesh_.vertices.empty()) fail("its scene has no positions");
        return std::move(mesh_);
    } catch (const json::exception&) {
        fail("its JSON is not glTF 2.0");
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw Error(ErrorCode::BadData, name_ + ": " + what + ": export it as glTF 2.0 binary");
    }

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

    const json& member(const char* key) const {
        const auto found = document_.find(key);
        if (found == document_.end() || !found->is_array()) fail(std::string("it has no ") + key);
        return *found;
    }

    const json& entry(const json& list, std::int64_t index, const char* what) const {
        if (index < 0 || index >= std::ssize(list))
            fail(std::string("it refers to a ") + what + " that does not exist");
        return list[static_cast<std::size_t>(index)];
    }

    static std::size_t size_of(int component_type) {
        switch (component_type) {
            case kUnsignedByte: return 1;
            case kUnsignedShort: return 2;
            case kUnsignedInt:
            case kFloat: return 4;
            default: return 0;
        }
    }

    Span span_of(std::int64_t accessor_index, std::string_view type, std::size_t num_components) {
        const json& accessor = entry(member("accessors"), accessor_index, "accessor");
        if (accessor.value("type", "") != type || accessor.contains("sparse"))
            fail("an accessor is sparse or not of type " + std::string(type));
        const json& view =
            entry(member("bufferViews"), accessor.value("bufferView", -1), "buffer view");
        if (view.value("buffer", -1) != 0) fail("its data is in another file");
        Span span;
        span.component_type = accessor.value("componentType", 0);
        const std::size_t size_bytes = num_components * size_of(span.component_type);
        const auto begin = accessor.value("byteOffset", std::uint64_t{0});
        const auto view_begin = view.value("byteOffset", std::uint64_t{0});
        const auto view_bytes = view.value("byteLength", std::uint64_t{0});
        const auto count = accessor.value("count", std::uint64_t{0});
        span.stride_bytes = view.value("byteStride", std::uint64_t{size_bytes});
        if (size_bytes == 0 || span.stride_bytes < size_bytes || span.stride_bytes > 252)
            fail("an accessor has a component type or stride that glTF does not define");
        const bool is_inside =
            view_begin <= buffer_.size() && view_bytes <= buffer_.size() - view_begin &&
            begin <= view_bytes &&
            (count == 0 || (view_bytes - begin >= size_bytes &&
                            count - 1 <= (view_bytes - begin - size_bytes) / span.stride_bytes));
        if (!is_inside) fail("an accessor reaches beyond its buffer");
        span.count = count;
        span.data = buffer_.data() + view_begin + begin;
        return span;
    }

    void add_node(int index, const Eigen::Affine3d& T_scene_parent, int depth) {
        if (depth > kMaxDepth) fail("its nodes are nested too deeply");
        const json& node = entry(member("nodes"), index, "node");
        visited_.resize(member("nodes").size(), false);
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
        for (const json& primitive : entry(member("meshes"), index, "mesh").at("primitives")) {
            const int mode = primitive.value("mode", kTriangles);
            if (mode != kTriangles && mode != kPoints) continue;
            const auto first = mesh_.vertices.size();
            const auto positions =
                span_of(primitive.at("attributes").at("POSITION").get<int>(), "VEC3", 3);
            if (positions.component_type != kFloat) fail("positions are not floats");
            if (positions.count > max_entries() - first) fail("it shows its meshes too often");
            for (std::size_t i = 0; i < positions.count; ++i) {
                Eigen::Vector3f p;
                std::memcpy(p.data(), positions.data + i * positions.stride_bytes, sizeof p);
                p = (T_scene_node * p.cast<double>()).cast<float>();
                if (!p.allFinite()) fail("a position is not finite");
                mesh_.vertices.push_back(p);
            }
            if (mode == kTriangles) add_triangles(primitive, first, positions.count);
        }
    }

    void add_triangles(const json& primitive, std::size_t first, std::size_t num_vertices) {
        std::vector<std::uint32_t> corners;
        if (primitive.contains("indices")) {
            const Span indices = span_of(primitive["indices"].get<int>(), "SCALAR", 1);
            if (indices.component_type == kFloat) fail("indices are floats instead of integers");
            for (std::size_t i = 0; i < indices.count; ++i) {
                std::uint32_t corner = 0;
                std::memcpy(&corner,
                            indices.data + i * indices.stride_bytes,
                            size_of(indices.component_type));
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
    std::vector<bool> visited_;  // nodes
    types::Mesh mesh_;
};

}  // namespace

types::Mesh parse_glb(std::string_view bytes, const std::string& name) {
    return GlbReader(name).read(bytes);
}

types::Mesh read_mesh(const std::filesystem::path& file) {
    constexpr std::uintmax_t kMax_bytes = std::uintmax_t{4} << 30;
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw Error(ErrorCode::NotFound, "cannot open " + file.string() + ": check the path");
    if (std::filesystem::file_size(file) > kMax_bytes)
        throw Error(ErrorCode::TooLarge, file.string() + " is larger than 4 GiB: simplify it");
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    const std::string name = file.filename().string();
    if (bytes.starts_with("ply")) return parse_ply(bytes, name);
    if (bytes.starts_with("glTF")) return parse_glb(bytes, name);
    return parse_obj(bytes, name);
}

}  // namespace divemesh::io
