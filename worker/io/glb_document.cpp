#include "worker/io/glb_document.hpp"

#include <meshoptimizer.h>
#include <utility>

#include "worker/io/gltf.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

constexpr int kVertexBuffer = 34962;  // buffer view targets
constexpr int kIndexBuffer = 34963;
constexpr int kLinear = 9729;  // samplers
constexpr int kLinearMipmapLinear = 9987;
constexpr int kClampToEdge = 33071;
constexpr std::size_t kMaxShortVertices = 65535;  // index 65535 restarts a primitive

std::string encode_attribute(std::string_view bytes, std::size_t stride_bytes) {
    const std::size_t count = bytes.size() / stride_bytes;
    std::string encoded(meshopt_encodeVertexBufferBound(count, stride_bytes), '\0');
    encoded.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(encoded.data()),
                                              encoded.size(),
                                              bytes.data(),
                                              count,
                                              stride_bytes));
    return encoded;
}

std::string encode_triangles(const std::vector<std::uint32_t>& corners, std::size_t num_vertices) {
    // The extension defines the second version of the index codec only.
    [[maybe_unused]] static const bool is_set = (meshopt_encodeIndexVersion(1), true);
    std::string encoded(meshopt_encodeIndexBufferBound(corners.size(), num_vertices), '\0');
    encoded.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(encoded.data()),
                                             encoded.size(),
                                             corners.data(),
                                             corners.size()));
    return encoded;
}

template <typename Value>
std::string_view bytes_of(const std::vector<Value>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)};
}

}  // namespace

GlbDocument::GlbDocument(GlbFile& file, GlbCompression compression)
    : file_(file), compression_(compression) {}

int GlbDocument::add_accessor(json accessor) {
    accessor["bufferView"] = views_.size() - 1;
    accessors_.push_back(std::move(accessor));
    return static_cast<int>(accessors_.size()) - 1;
}

json GlbDocument::compressed_view(const std::string& encoded,
                                  const char* mode,
                                  std::size_t count,
                                  std::size_t stride_bytes) {
    json view = {
        {"buffer", 1}, {"byteOffset", decoded_bytes_}, {"byteLength", count * stride_bytes}};
    view["extensions"][kGltfMeshopt] = {{"buffer", 0},
                                        {"byteOffset", file_.add(encoded)},
                                        {"byteLength", encoded.size()},
                                        {"byteStride", stride_bytes},
                                        {"count", count},
                                        {"mode", mode}};
    decoded_bytes_ += (count * stride_bytes + 3) / 4 * 4;
    return view;
}

int GlbDocument::add_attribute(std::string_view bytes, std::size_t stride_bytes, json accessor) {
    json view;
    if (compression_ == GlbCompression::Meshopt)
        view = compressed_view(encode_attribute(bytes, stride_bytes),
                               "ATTRIBUTES",
                               bytes.size() / stride_bytes,
                               stride_bytes);
    else
        view = {{"buffer", 0}, {"byteOffset", file_.add(bytes)}, {"byteLength", bytes.size()}};
    view["byteStride"] = stride_bytes;
    view["target"] = kVertexBuffer;
    views_.push_back(std::move(view));
    return add_accessor(std::move(accessor));
}

int GlbDocument::add_triangles(const std::vector<std::uint32_t>& corners,
                               std::size_t num_vertices) {
    const bool is_short = num_vertices <= kMaxShortVertices;
    const std::size_t size_bytes = is_short ? sizeof(std::uint16_t) : sizeof(std::uint32_t);
    json view;
    if (compression_ == GlbCompression::Meshopt) {
        view = compressed_view(
            encode_triangles(corners, num_vertices), "TRIANGLES", corners.size(), size_bytes);
    } else {
        const std::vector<std::uint16_t> shorts(corners.begin(),
                                                is_short ? corners.end() : corners.begin());
        view = {{"buffer", 0},
                {"byteOffset", file_.add(is_short ? bytes_of(shorts) : bytes_of(corners))},
                {"byteLength", corners.size() * size_bytes}};
    }
    view["target"] = kIndexBuffer;
    views_.push_back(std::move(view));
    return add_accessor({{"componentType", is_short ? kGltfUnsignedShort : kGltfUnsignedInt},
                         {"type", "SCALAR"},
                         {"count", corners.size()}});
}

int GlbDocument::add_material() {
    materials_.push_back(
        {{"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}},
         {"doubleSided", true},
         {"extensions", {{"KHR_materials_unlit", json::object()}}}});
    return static_cast<int>(materials_.size()) - 1;
}

int GlbDocument::add_material(std::string_view jpeg) {
    views_.push_back({{"buffer", 0}, {"byteOffset", file_.add(jpeg)}, {"byteLength", jpeg.size()}});
    images_.push_back({{"bufferView", views_.size() - 1}, {"mimeType", "image/jpeg"}});
    textures_.push_back({{"sampler", 0}, {"source", images_.size() - 1}});
    const int material = add_material();
    materials_.back()["pbrMetallicRoughness"]["baseColorTexture"] = {
        {"index", textures_.size() - 1}};
    return material;
}

void GlbDocument::add_extensions(json& document) const {
    document["extensionsUsed"] = {"KHR_materials_unlit"};
    if (compression_ == GlbCompression::None) return;
    document["extensionsRequired"] = {"KHR_mesh_quantization"};
    if (compression_ == GlbCompression::Meshopt) {
        document["extensionsRequired"].push_back(kGltfMeshopt);
        document["buffers"].push_back({{"byteLength", decoded_bytes_},
                                       {"extensions", {{kGltfMeshopt, {{"fallback", true}}}}}});
    }
    for (const json& extension : document["extensionsRequired"])
        document["extensionsUsed"].push_back(extension);
}

json GlbDocument::finish(const json& primitives, const json& node) const {
    json document = {{"asset", {{"version", "2.0"}, {"generator", "divemesh"}}},
                     {"scene", 0},
                     {"scenes", {{{"name", "dive"}}}}};
    if (primitives.empty()) return document;
    document["scenes"][0]["nodes"] = {0};
    document["nodes"] = json::array({node});
    document["meshes"] = {{{"primitives", primitives}}};
    document["materials"] = materials_;
    if (!images_.empty()) {
        document["images"] = images_;
        document["textures"] = textures_;
        document["samplers"] = {{{"magFilter", kLinear},
                                 {"minFilter", kLinearMipmapLinear},
                                 {"wrapS", kClampToEdge},
                                 {"wrapT", kClampToEdge}}};
    }
    document["accessors"] = accessors_;
    document["bufferViews"] = views_;
    document["buffers"] = {{{"byteLength", file_.size_bytes()}}};
    add_extensions(document);
    return document;
}

}  // namespace divemesh::io
