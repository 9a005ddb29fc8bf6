#include "worker/io/glb_writer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/io/mesh_check.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little);

constexpr int kUnsignedShort = 5123;  // glTF component types
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kVertexBuffer = 34962;  // buffer view targets
constexpr int kIndexBuffer = 34963;

using LinearColor = std::array<std::uint16_t, 4>;

template <typename Value>
std::string_view bytes_of(const std::vector<Value>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)};
}

// Converts by IEC 61966-2-1.
std::uint16_t linear_from_srgb(std::uint8_t srgb) {
    const double s = srgb / 255.0;
    const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    return static_cast<std::uint16_t>(std::lround(linear * 65535.0));
}

std::vector<LinearColor> linear_colors(const std::vector<types::Color>& colors) {
    std::array<std::uint16_t, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = linear_from_srgb(static_cast<std::uint8_t>(i));
    std::vector<LinearColor> linear;
    linear.reserve(colors.size());
    for (const types::Color& color : colors)
        linear.push_back({table[color[0]], table[color[1]], table[color[2]], 65535});
    return linear;
}

// Builds the document and the buffer together; each accessor has its own buffer view.
class Document {
public:
    template <typename Value>
    int add(const std::vector<Value>& values, int target, json accessor) {
        const std::string_view bytes = bytes_of(values);
        views_.push_back({{"buffer", 0},
                          {"byteOffset", size_bytes_},
                          {"byteLength", bytes.size()},
                          {"target", target}});
        accessor["bufferView"] = views_.size() - 1;
        accessors_.push_back(std::move(accessor));
        parts_.push_back(bytes);
        size_bytes_ += bytes.size();
        return static_cast<int>(accessors_.size()) - 1;
    }

    json finish(const json& primitive) const {
        const double half = std::sqrt(0.5);
        json document = {{"asset", {{"version", "2.0"}, {"generator", "divemesh"}}},
                         {"scene", 0},
                         {"scenes", {{{"name", "dive"}}}}};
        if (parts_.empty()) return document;
        document["scenes"][0]["nodes"] = {0};
        document["nodes"] = {
            {{"name", "z_up_to_y_up"}, {"mesh", 0}, {"rotation", {-half, 0.0, 0.0, half}}}};
        document["meshes"] = {{{"primitives", {primitive}}}};
        document["materials"] = {
            {{"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}},
             {"doubleSided", true},
             {"extensions", {{"KHR_materials_unlit", json::object()}}}}};
        document["extensionsUsed"] = {"KHR_materials_unlit"};
        document["accessors"] = accessors_;
        document["bufferViews"] = views_;
        document["buffers"] = {{{"byteLength", size_bytes_}}};
        return document;
    }

    const std::vector<std::string_view>& parts() const { return parts_; }
    std::size_t size_bytes() const { return size_bytes_; }

private:
    json accessors_ = json::array();
    json views_ = json::array();
    std::vector<std::string_view> parts_;
    std::size_t size_bytes_ = 0;
};

json vector_of(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

json position_accessor(const std::vector<Eigen::Vector3f>& vertices) {
    Eigen::Vector3f low = vertices.front();
    Eigen::Vector3f high = vertices.front();
    for (const Eigen::Vector3f& vertex : vertices) {
        low = low.cwiseMin(vertex);
        high = high.cwiseMax(vertex);
    }
    return {{"componentType", kFloat},
            {"type", "VEC3"},
            {"count", vertices.size()},
            {"min", vector_of(low)},
            {"max", vector_of(high)}};
}

std::string little_endian(std::uint32_t value) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
}

// Header, JSON chunk, binary chunk (glTF 2.0, section 4.4).
void write_chunks(const std::filesystem::path& file, std::string text, const Document& document) {
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const bool has_buffer = document.size_bytes() > 0;
    const std::size_t total = 12 + 8 + text.size() + (has_buffer ? 8 + document.size_bytes() : 0);
    if (total > std::numeric_limits<std::uint32_t>::max())
        throw Error(
            ErrorCode::TooLarge,
            file.string() + " would exceed the 4 GiB limit of glTF binary: choose a larger voxel");
    base::AtomicFile output(file);
    output.write("glTF" + little_endian(2) + little_endian(static_cast<std::uint32_t>(total)));
    output.write(little_endian(static_cast<std::uint32_t>(text.size())) + "JSON" + text);
    if (has_buffer) {
        output.write(little_endian(static_cast<std::uint32_t>(document.size_bytes())) +
                     std::string("BIN\0", 4));
        for (const std::string_view part : document.parts()) output.write(part);
    }
    output.commit();
}

}  // namespace

void write_glb(const std::filesystem::path& file, const types::Mesh& mesh) {
    check_mesh(mesh);
    const std::size_t count = mesh.vertices.size();
    const std::vector<Eigen::Vector3f> normals = unit_normals(mesh);
    const std::vector<LinearColor> colors = linear_colors(mesh.colors);
    Document document;
    json primitive;
    if (!mesh.triangles.empty()) {
        primitive = {{"mode", 4}, {"material", 0}};
        primitive["attributes"]["POSITION"] =
            document.add(mesh.vertices, kVertexBuffer, position_accessor(mesh.vertices));
        primitive["attributes"]["NORMAL"] =
            document.add(normals,
                         kVertexBuffer,
                         {{"componentType", kFloat}, {"type", "VEC3"}, {"count", count}});
        if (!colors.empty())
            primitive["attributes"]["COLOR_0"] = document.add(colors,
                                                              kVertexBuffer,
                                                              {{"componentType", kUnsignedShort},
                                                               {"normalized", true},
                                                               {"type", "VEC4"},
                                                               {"count", count}});
        primitive["indices"] = document.add(mesh.triangles,
                                            kIndexBuffer,
                                            {{"componentType", kUnsignedInt},
                                             {"type", "SCALAR"},
                                             {"count", mesh.triangles.size() * 3}});
    }
    write_chunks(file, document.finish(primitive).dump(), document);
}

}  // namespace divemesh::io
