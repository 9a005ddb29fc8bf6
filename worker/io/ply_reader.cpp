#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>

#include "schemas/error.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/ply_header.hpp"

namespace divemesh::io {
namespace {

// Reads the scalars of the body one by one.
class Body {
public:
    Body(std::string_view bytes, PlyFormat format, const std::string& name)
        : rest_(bytes), format_(format), name_(name) {}

    double next(PlyScalar scalar) { return format_ == PlyFormat::Ascii ? word() : binary(scalar); }
    std::size_t remaining_bytes() const { return rest_.size(); }

private:
    double word() {
        const std::size_t start = std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size());
        rest_.remove_prefix(start);
        double value = 0.0;
        const auto [end, code] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
        if (code != std::errc())
            fail_ply(name_, "PLY body is incomplete or contains text that is not a number");
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        return value;
    }

    template <typename Value>
    double take() {
        char raw[sizeof(Value)];
        std::memcpy(raw, rest_.data(), sizeof raw);
        if (format_ == PlyFormat::BigEndian) std::reverse(std::begin(raw), std::end(raw));
        Value value;
        std::memcpy(&value, raw, sizeof raw);
        rest_.remove_prefix(sizeof raw);
        return static_cast<double>(value);
    }

    double binary(PlyScalar scalar) {
        if (rest_.size() < size_of(scalar)) fail_ply(name_, "PLY body is cut short");
        switch (scalar) {
            case PlyScalar::Int8: return take<std::int8_t>();
            case PlyScalar::Uint8: return take<std::uint8_t>();
            case PlyScalar::Int16: return take<std::int16_t>();
            case PlyScalar::Uint16: return take<std::uint16_t>();
            case PlyScalar::Int32: return take<std::int32_t>();
            case PlyScalar::Uint32: return take<std::uint32_t>();
            case PlyScalar::Float32: return take<float>();
            case PlyScalar::Float64: return take<double>();
        }
        return 0.0;
    }

    std::string_view rest_;
    PlyFormat format_;
    const std::string& name_;
};

// Returns the minimum number of bytes of an element, which bounds a hostile count before memory is
// allocated.
std::size_t min_bytes(const PlyElement& element, PlyFormat format) {
    std::size_t bytes = 0;
    for (const PlyProperty& property : element.properties)
        bytes +=
            format == PlyFormat::Ascii ? 1 : size_of(property.count_type.value_or(property.type));
    return std::max<std::size_t>(bytes, 1);
}

std::uint64_t list_length(const PlyProperty& property, Body& body, const std::string& name) {
    const double count = body.next(*property.count_type);
    if (!(count >= 0.0 && count <= static_cast<double>(body.remaining_bytes())))
        fail_ply(name, "PLY list is longer than the file");
    return static_cast<std::uint64_t>(count);
}

std::uint8_t color_channel(double value, PlyScalar type) {
    const double scaled =
        type == PlyScalar::Float32 || type == PlyScalar::Float64 ? value * 255.0 : value;
    return static_cast<std::uint8_t>(std::clamp(std::isfinite(scaled) ? scaled : 0.0, 0.0, 255.0));
}

enum class Target {
    X,
    Y,
    Z,
    Nx,
    Ny,
    Nz,
    Red,
    Green,
    Blue,
    Sigma,
    SigmaLocal,
    NumObservations,
    None
};

Target target_of(std::string_view name) {
    static constexpr std::string_view kNames[] = {"x",
                                                  "y",
                                                  "z",
                                                  "nx",
                                                  "ny",
                                                  "nz",
                                                  "red",
                                                  "green",
                                                  "blue",
                                                  "sigma",
                                                  "sigma_local",
                                                  "num_observations"};
    const auto* found = std::find(std::begin(kNames), std::end(kNames), name);
    return static_cast<Target>(found - std::begin(kNames));
}

void read_vertices(const PlyElement& element,
                   Body& body,
                   const std::string& name,
                   types::Mesh& mesh) {
    std::vector<Target> targets;
    for (const PlyProperty& property : element.properties)
        targets.push_back(property.count_type ? Target::None : target_of(property.name));
    const auto has = [&](Target target) {
        return std::find(targets.begin(), targets.end(), target) != targets.end();
    };
    if (!has(Target::X) || !has(Target::Y) || !has(Target::Z)) fail_ply(name, "PLY has no x, y, z");
    if (!mesh.vertices.empty()) fail_ply(name, "PLY has two lists of vertices");
    mesh.vertices.resize(element.count, Eigen::Vector3f::Zero());
    if (has(Target::Nx)) mesh.normals.resize(element.count, Eigen::Vector3f::Zero());
    if (has(Target::Red)) mesh.colors.resize(element.count);
    if (has(Target::Sigma)) mesh.sigma_m.resize(element.count);
    if (has(Target::SigmaLocal)) mesh.sigma_local_m.resize(element.count);
    if (has(Target::NumObservations)) mesh.num_observations.resize(element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
        for (std::size_t p = 0; p < targets.size(); ++p) {
            const PlyProperty& property = element.properties[p];
            if (property.count_type) {
                for (auto left = list_length(property, body, name); left > 0; --left)
                    body.next(property.type);
                continue;
            }
            const double value = body.next(property.type);
            const auto target = targets[p];
            const int slot = static_cast<int>(target);
            if (target <= Target::Z)
                mesh.vertices[i][slot] = static_cast<float>(value);
            else if (target <= Target::Nz && !mesh.normals.empty())
                mesh.normals[i][slot - 3] = static_cast<float>(value);
            else if (target >= Target::Red && target <= Target::Blue && !mesh.colors.empty())
                mesh.colors[i][static_cast<std::size_t>(slot - 6)] =
                    color_channel(value, property.type);
            else if (target == Target::Sigma)
                mesh.sigma_m[i] = static_cast<float>(value);
            else if (target == Target::SigmaLocal)
                mesh.sigma_local_m[i] = static_cast<float>(value);
            else if (target == Target::NumObservations)
                mesh.num_observations[i] =
                    static_cast<std::uint32_t>(value > 0.0 ? std::min(value, 4294967295.0) : 0.0);
        }
        if (!mesh.vertices[i].allFinite())
            fail_ply(name, "PLY vertex " + std::to_string(i) + " is not finite");
    }
}

std::uint32_t vertex_index(double value, const types::Mesh& mesh, const std::string& name) {
    if (!(value >= 0.0 && value < static_cast<double>(mesh.vertices.size())))
        fail_ply(name, "PLY face refers to a vertex that does not exist");
    return static_cast<std::uint32_t>(value);
}

// Splits a polygon into a fan around its first corner.
void read_polygon(const PlyProperty& property,
                  Body& body,
                  const std::string& name,
                  types::Mesh& mesh) {
    std::uint32_t first = 0;
    std::uint32_t previous = 0;
    const std::uint64_t num_corners = list_length(property, body, name);
    for (std::uint64_t corner = 0; corner < num_corners; ++corner) {
        const std::uint32_t vertex = vertex_index(body.next(property.type), mesh, name);
        if (corner == 0) first = vertex;
        if (corner >= 2) mesh.triangles.push_back({first, previous, vertex});
        previous = vertex;
    }
}

void read_other(const PlyElement& element, Body& body, const std::string& name, types::Mesh& mesh) {
    if (element.name == "face") mesh.triangles.reserve(element.count);
    for (std::uint64_t i = 0; i < element.count; ++i)
        for (const PlyProperty& property : element.properties) {
            const bool is_polygon =
                element.name == "face" && property.count_type &&
                (property.name == "vertex_indices" || property.name == "vertex_index");
            if (is_polygon) {
                read_polygon(property, body, name, mesh);
                continue;
            }
            for (auto left = property.count_type ? list_length(property, body, name) : 1; left > 0;
                 --left)
                body.next(property.type);
        }
}

}  // namespace

types::Mesh parse_ply(std::string_view bytes, const std::string& name) {
    const PlyHeader header = parse_ply_header(bytes, name);
    Body body(bytes.substr(header.size_bytes), header.format, name);
    types::Mesh mesh;
    for (const PlyElement& element : header.elements) {
        if (element.count > body.remaining_bytes() / min_bytes(element, header.format))
            fail_ply(name,
                     "PLY announces " + std::to_string(element.count) + " of element " +
                         element.name + ", but the file is too short: copy it again");
        if (element.name == "vertex")
            read_vertices(element, body, name, mesh);
        else
            read_other(element, body, name, mesh);
    }
    return mesh;
}

types::Mesh read_ply(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw Error(ErrorCode::NotFound, "cannot open " + file.string() + ": check the path");
    std::error_code unknown;
    const std::uintmax_t size_bytes = std::filesystem::file_size(file, unknown);
    std::string bytes;
    if (!unknown) bytes.reserve(size_bytes);  // avoids twice the memory while growing
    std::vector<char> segment(1 << 20);
    while (stream.read(segment.data(), std::ssize(segment)) || stream.gcount() > 0)
        bytes.append(segment.data(), static_cast<std::size_t>(stream.gcount()));
    return parse_ply(bytes, file.filename().string());
}

}  // namespace divemesh::io
