#include "worker/io/glb_buffers.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <meshoptimizer.h>

#include "schemas/error.hpp"
#include "worker/io/gltf.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little);

constexpr std::uint64_t kMaxStride_bytes = 252;  // glTF 2.0, section 5.11
// No codec of the extension makes less than a byte of this many.
constexpr std::uint64_t kMaxExpansion = 64;

std::size_t size_of(int component_type) {
    switch (component_type) {
        case kGltfByte:
        case kGltfUnsignedByte: return 1;
        case kGltfShort:
        case kGltfUnsignedShort: return 2;
        case kGltfUnsignedInt:
        case kGltfFloat: return 4;
        default: return 0;
    }
}

template <typename Value>
double value_at(const char* data, bool is_normalised) {
    Value value{};
    std::memcpy(&value, data, sizeof value);
    const auto number = static_cast<double>(value);
    if (!is_normalised || !std::numeric_limits<Value>::is_integer) return number;
    return std::max(number / static_cast<double>(std::numeric_limits<Value>::max()), -1.0);
}

// Returns whether meshoptimizer can decode a stream of these sizes; it asserts what it needs.
bool is_defined(std::string_view mode, std::uint64_t count, std::uint64_t stride_bytes) {
    if (mode == "ATTRIBUTES")
        return stride_bytes > 0 && stride_bytes <= kMaxStride_bytes && stride_bytes % 4 == 0;
    if (stride_bytes != 2 && stride_bytes != 4) return false;
    return mode == "INDICES" || (mode == "TRIANGLES" && count % 3 == 0);
}

bool decode(std::string_view mode,
            std::uint64_t count,
            std::uint64_t stride_bytes,
            std::string_view encoded,
            std::vector<char>& decoded) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(encoded.data());
    if (mode == "ATTRIBUTES")
        return meshopt_decodeVertexBuffer(
                   decoded.data(), count, stride_bytes, bytes, encoded.size()) == 0;
    if (mode == "TRIANGLES")
        return meshopt_decodeIndexBuffer(
                   decoded.data(), count, stride_bytes, bytes, encoded.size()) == 0;
    return meshopt_decodeIndexSequence(
               decoded.data(), count, stride_bytes, bytes, encoded.size()) == 0;
}

// Returns whether the filter is one of positions, texture coordinates or indices.
bool undo_filter(std::string_view filter,
                 std::uint64_t count,
                 std::uint64_t stride_bytes,
                 char* data) {
    if (filter == "NONE") return true;
    if (filter != "EXPONENTIAL" || stride_bytes % 4 != 0) return false;
    meshopt_decodeFilterExp(data, count, stride_bytes);
    return true;
}

}  // namespace

void fail_glb(const std::string& name, const std::string& what) {
    throw Error(ErrorCode::BadData, name + ": " + what + ": export it as glTF 2.0 binary");
}

const json& glb_entry(const json& document,
                      const char* list,
                      std::int64_t index,
                      const std::string& name) {
    const auto found = document.find(list);
    if (found == document.end() || !found->is_array())
        fail_glb(name, std::string("it has no ") + list);
    if (index < 0 || index >= std::ssize(*found))
        fail_glb(name, std::string("it refers to one of ") + list + " that does not exist");
    return (*found)[static_cast<std::size_t>(index)];
}

double AccessorValues::component(std::size_t value, std::size_t index) const {
    const char* at = data + value * stride_bytes + index * size_of(component_type);
    switch (component_type) {
        case kGltfByte: return value_at<std::int8_t>(at, is_normalised);
        case kGltfUnsignedByte: return value_at<std::uint8_t>(at, is_normalised);
        case kGltfShort: return value_at<std::int16_t>(at, is_normalised);
        case kGltfUnsignedShort: return value_at<std::uint16_t>(at, is_normalised);
        case kGltfUnsignedInt: return value_at<std::uint32_t>(at, is_normalised);
        default: return value_at<float>(at, is_normalised);
    }
}

std::uint32_t AccessorValues::integer(std::size_t value) const {
    std::uint32_t number = 0;
    std::memcpy(&number, data + value * stride_bytes, size_of(component_type));
    return number;
}

std::string_view GlbBuffers::part_of(const json& view) const {
    if (view.value("buffer", -1) != 0) fail_glb(name_, "its data is in another file");
    const auto begin = view.value("byteOffset", std::uint64_t{0});
    const auto num_bytes = view.value("byteLength", std::uint64_t{0});
    if (begin > buffer_.size() || num_bytes > buffer_.size() - begin)
        fail_glb(name_, "a buffer view reaches beyond its buffer");
    return buffer_.substr(begin, num_bytes);
}

GlbBuffers::View GlbBuffers::decompressed(std::int64_t index, const json& compression) {
    const auto mode = compression.value("mode", "");
    const auto count = compression.value("count", std::uint64_t{0});
    const auto stride_bytes = compression.value("byteStride", std::uint64_t{0});
    const auto [found, is_new] = decompressed_.try_emplace(index);
    if (is_new) {
        const std::string_view encoded = part_of(compression);
        if (!is_defined(mode, count, stride_bytes))
            fail_glb(name_, "a compressed buffer view has a mode or stride that is not defined");
        const std::uint64_t left =
            kMaxExpansion * std::uint64_t{buffer_.size()} - decompressed_bytes_;
        const std::uint64_t num_bytes = std::min(kMaxExpansion * encoded.size(), left);
        if (count > num_bytes / stride_bytes)
            fail_glb(name_, "a compressed buffer view is too short for its values");
        decompressed_bytes_ += count * stride_bytes;
        found->second.resize(count * stride_bytes);
        if (count > 0 &&
            (!decode(mode, count, stride_bytes, encoded, found->second) ||
             !undo_filter(
                 compression.value("filter", "NONE"), count, stride_bytes, found->second.data())))
            fail_glb(name_, "a compressed buffer view cannot be decompressed");
    }
    return {{found->second.data(), found->second.size()}, stride_bytes};
}

GlbBuffers::View GlbBuffers::view_of(std::int64_t index) {
    const json& view = glb_entry(document_, "bufferViews", index, name_);
    if (const auto extensions = view.find("extensions"); extensions != view.end())
        if (const auto compression = extensions->find(kGltfMeshopt);
            compression != extensions->end())
            return decompressed(index, *compression);
    return {part_of(view), view.value("byteStride", std::uint64_t{0})};
}

AccessorValues GlbBuffers::values_of(std::int64_t accessor_index,
                                     std::string_view type,
                                     std::size_t num_components) {
    const json& accessor = glb_entry(document_, "accessors", accessor_index, name_);
    if (accessor.value("type", "") != type || accessor.contains("sparse"))
        fail_glb(name_, "an accessor is sparse or not of type " + std::string(type));
    const View view = view_of(accessor.value("bufferView", -1));
    AccessorValues values;
    values.component_type = accessor.value("componentType", 0);
    values.is_normalised = accessor.value("normalized", false);
    const std::size_t size_bytes = num_components * size_of(values.component_type);
    const auto begin = accessor.value("byteOffset", std::uint64_t{0});
    const auto count = accessor.value("count", std::uint64_t{0});
    values.stride_bytes = view.stride_bytes == 0 ? size_bytes : view.stride_bytes;
    if (size_bytes == 0 || values.stride_bytes < size_bytes ||
        values.stride_bytes > kMaxStride_bytes)
        fail_glb(name_, "an accessor has a component type or stride that glTF does not define");
    const bool is_inside = begin <= view.bytes.size() &&
                           (count == 0 || (view.bytes.size() - begin >= size_bytes &&
                                           count - 1 <= (view.bytes.size() - begin - size_bytes) /
                                                            values.stride_bytes));
    if (!is_inside) fail_glb(name_, "an accessor reaches beyond its buffer");
    values.count = count;
    values.data = view.bytes.data() + begin;
    return values;
}

}  // namespace divemesh::io
