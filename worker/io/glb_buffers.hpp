#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh::io {

// Throws Error{BadData} that names the file and the problem.
[[noreturn]] void fail_glb(const std::string& name, const std::string& what);

// Returns an entry of a list of the document, such as an accessor.
const nlohmann::json& glb_entry(const nlohmann::json& document,
                                const char* list,
                                std::int64_t index,
                                const std::string& name);

// The values of an accessor, all of them inside their buffer.
struct AccessorValues {
    // Returns a component of a value as glTF defines it: normalised integers are -1 to 1.
    double component(std::size_t value, std::size_t index) const;
    std::uint32_t integer(std::size_t value) const;  // of an unsigned type

    const char* data = nullptr;
    std::size_t count = 0;
    std::size_t stride_bytes = 0;
    int component_type = 0;
    bool is_normalised = false;
};

// The binary chunk of a GLB, as its accessors see it. Views with EXT_meshopt_compression are
// decompressed when they are first needed. Every size is checked before memory is allocated.
class GlbBuffers {
public:
    // Keeps references to all three.
    GlbBuffers(const nlohmann::json& document, std::string_view buffer, const std::string& name)
        : document_(document), buffer_(buffer), name_(name) {}

    AccessorValues values_of(std::int64_t accessor_index,
                             std::string_view type,
                             std::size_t num_components);
    std::string_view bytes_of_view(std::int64_t index) { return view_of(index).bytes; }

private:
    struct View {
        std::string_view bytes;
        std::uint64_t stride_bytes = 0;  // 0: values without gaps
    };

    View view_of(std::int64_t index);
    std::string_view part_of(const nlohmann::json& view) const;
    View decompressed(std::int64_t index, const nlohmann::json& compression);

    const nlohmann::json& document_;
    std::string_view buffer_;
    const std::string& name_;
    std::map<std::int64_t, std::vector<char>> decompressed_;  // by the index of the view
    std::uint64_t decompressed_bytes_ = 0;
};

}  // namespace divemesh::io
