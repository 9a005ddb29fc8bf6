#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "worker/io/glb_file.hpp"
#include "worker/io/glb_writer.hpp"

namespace divemesh::io {

// The accessors, buffer views, images and materials of a glTF document, and the buffer that they
// describe.
class GlbDocument {
public:
    GlbDocument(GlbFile& file, GlbCompression compression);

    // Adds an attribute, one value of `stride_bytes` per vertex; `accessor` states componentType
    // and type. Returns the accessor's index.
    template <typename Value>
    int add_attribute(const std::vector<Value>& values, nlohmann::json accessor) {
        static_assert(sizeof(Value) % 4 == 0);
        accessor["count"] = values.size();
        return add_attribute(
            {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)},
            sizeof(Value),
            std::move(accessor));
    }
    // Adds the corners of triangles, three to each. Returns the accessor's index.
    int add_triangles(const std::vector<std::uint32_t>& corners, std::size_t num_vertices);
    // Adds an unlit material. Returns its index.
    int add_material();
    int add_material(std::string_view jpeg);

    // Returns the whole document of one mesh, shown by one node. Without primitives the scene is
    // empty.
    nlohmann::json finish(const nlohmann::json& primitives, const nlohmann::json& node) const;

private:
    int add_attribute(std::string_view bytes, std::size_t stride_bytes, nlohmann::json accessor);
    int add_accessor(nlohmann::json accessor);
    nlohmann::json compressed_view(const std::string& encoded,
                                   const char* mode,
                                   std::size_t count,
                                   std::size_t stride_bytes);
    void add_extensions(nlohmann::json& document) const;

    GlbFile& file_;
    GlbCompression compression_;
    std::uint64_t decoded_bytes_ = 0;  // of the buffer that compressed views decode to
    nlohmann::json accessors_ = nlohmann::json::array();
    nlohmann::json views_ = nlohmann::json::array();
    nlohmann::json images_ = nlohmann::json::array();
    nlohmann::json textures_ = nlohmann::json::array();
    nlohmann::json materials_ = nlohmann::json::array();
};

}  // namespace divemesh::io
