#include "worker/io/ply_header.hpp"

#include <sstream>
#include <utility>

#include "schemas/error.hpp"

namespace divemesh::io {
namespace {

std::optional<PlyScalar> scalar_from_text(std::string_view text) {
    // clang-format off
    static constexpr std::pair<std::string_view, PlyScalar> kNames[] = {
        {"char", PlyScalar::Int8},     {"int8", PlyScalar::Int8},      {"uchar", PlyScalar::Uint8},
        {"uint8", PlyScalar::Uint8},   {"short", PlyScalar::Int16},    {"int16", PlyScalar::Int16},
        {"ushort", PlyScalar::Uint16}, {"uint16", PlyScalar::Uint16},  {"int", PlyScalar::Int32},
        {"int32", PlyScalar::Int32},   {"uint", PlyScalar::Uint32},    {"uint32", PlyScalar::Uint32},
        {"float", PlyScalar::Float32}, {"float32", PlyScalar::Float32},
        {"double", PlyScalar::Float64}, {"float64", PlyScalar::Float64}};
    // clang-format on
    for (const auto& [known, scalar] : kNames)
        if (known == text) return scalar;
    return std::nullopt;
}

PlyProperty parse_property(std::istringstream& words, const std::string& name) {
    PlyProperty property;
    std::string type;
    words >> type;
    if (type == "list") {
        words >> type;
        property.count_type = scalar_from_text(type);
        if (!property.count_type) fail_ply(name, "PLY header: unknown list type '" + type + "'");
        words >> type;
    }
    const auto scalar = scalar_from_text(type);
    words >> property.name;
    if (!scalar || property.name.empty()) fail_ply(name, "PLY header: bad property '" + type + "'");
    property.type = *scalar;
    return property;
}

void parse_header_line(const std::string& line, const std::string& name, PlyHeader& header) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "format") {
        words >> word;
        if (word == "ascii")
            header.format = PlyFormat::Ascii;
        else if (word == "binary_little_endian")
            header.format = PlyFormat::LittleEndian;
        else if (word == "binary_big_endian")
            header.format = PlyFormat::BigEndian;
        else
            fail_ply(name, "unknown PLY format '" + word + "'");
    } else if (word == "element") {
        PlyElement element;
        words >> element.name >> element.count;
        if (!words) fail_ply(name, "PLY header: bad element '" + line + "'");
        header.elements.push_back(element);
    } else if (word == "property") {
        if (header.elements.empty()) fail_ply(name, "PLY header: a property before any element");
        header.elements.back().properties.push_back(parse_property(words, name));
    } else if (word != "comment" && word != "obj_info" && word != "ply") {
        fail_ply(name, "PLY header: unknown line '" + line.substr(0, 60) + "'");
    }
}

}  // namespace

void fail_ply(const std::string& name, const std::string& what) {
    throw Error(ErrorCode::BadData, name + ": " + what);
}

std::size_t size_of(PlyScalar scalar) {
    switch (scalar) {
        case PlyScalar::Int8:
        case PlyScalar::Uint8: return 1;
        case PlyScalar::Int16:
        case PlyScalar::Uint16: return 2;
        case PlyScalar::Int32:
        case PlyScalar::Uint32:
        case PlyScalar::Float32: return 4;
        case PlyScalar::Float64: return 8;
    }
    return 0;
}

PlyHeader parse_ply_header(std::string_view bytes, const std::string& name) {
    if (!bytes.starts_with("ply")) fail_ply(name, "not a PLY file");
    PlyHeader header;
    for (int num_lines = 0; num_lines < 1000; ++num_lines) {
        const std::size_t end = bytes.find('\n', header.size_bytes);
        if (end == std::string_view::npos) break;
        std::string line(bytes.substr(header.size_bytes, end - header.size_bytes));
        header.size_bytes = end + 1;
        if (line.ends_with('\r')) line.pop_back();
        if (line == "end_header") return header;
        parse_header_line(line, name, header);
    }
    fail_ply(name, "PLY header has no end_header");
}

}  // namespace divemesh::io
