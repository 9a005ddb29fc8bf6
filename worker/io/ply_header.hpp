#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh::io {

enum class PlyFormat { Ascii, LittleEndian, BigEndian };
enum class PlyScalar { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };

struct PlyProperty {
    std::string name;
    PlyScalar type = PlyScalar::Float32;
    std::optional<PlyScalar> count_type;  // set for a list
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
};

struct PlyHeader {
    PlyFormat format = PlyFormat::Ascii;
    std::vector<PlyElement> elements;
    std::size_t size_bytes = 0;
};

// Throws Error{BadData} that begins with the name of the file.
[[noreturn]] void fail_ply(const std::string& name, const std::string& what);

std::size_t size_of(PlyScalar scalar);

// Parses the header at the start of a PLY file, or of what is known of it. Throws Error{BadData}
// that names the file and the problem.
PlyHeader parse_ply_header(std::string_view bytes, const std::string& name);

}  // namespace divemesh::io
