#include "worker/io/cloud_ply_reader.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string_view>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh::io {
namespace {

constexpr std::size_t kMaxHeader_bytes = std::size_t{1} << 16;
constexpr std::size_t kPoint_bytes = 3 * sizeof(float) + 3;

std::ifstream open(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw Error(ErrorCode::NotFound, "cannot open " + file.string() + ": check the path");
    return stream;
}

// Returns whether points are x y z as float and red green blue as uchar.
bool is_cloud(const PlyElement& element) {
    constexpr std::array<std::string_view, 6> kNames = {"x", "y", "z", "red", "green", "blue"};
    if (element.name != "vertex" || element.properties.size() != kNames.size()) return false;
    for (std::size_t i = 0; i < kNames.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        const PlyScalar type = i < 3 ? PlyScalar::Float32 : PlyScalar::Uint8;
        if (property.name != kNames[i] || property.type != type || property.count_type)
            return false;
    }
    return true;
}

}  // namespace

CloudPlyReader::CloudPlyReader(const std::filesystem::path& file) : file_(file) {
    std::ifstream stream = open(file);
    std::string start(kMaxHeader_bytes, '\0');
    stream.read(start.data(), static_cast<std::streamsize>(start.size()));
    start.resize(static_cast<std::size_t>(stream.gcount()));
    const std::string name = file.filename().string();
    PlyHeader header = parse_ply_header(start, name);
    if (header.format != PlyFormat::LittleEndian || header.elements.size() != 1 ||
        !is_cloud(header.elements[0]))
        fail_ply(name, "not a cloud that divemesh wrote: copy the whole reconstruction again");
    header_bytes_ = header.size_bytes;
    vertices_ = std::move(header.elements[0]);
    if (num_points() > (std::filesystem::file_size(file) - header_bytes_) / kPoint_bytes)
        fail_ply(name, "PLY body is cut short");
}

void CloudPlyReader::for_each(
    const std::function<void(const Eigen::Vector3f&, const types::Color&)>& visit) const {
    constexpr std::uint64_t kMaxPoints = 1U << 16;
    std::ifstream stream = open(file_);
    stream.seekg(static_cast<std::streamoff>(header_bytes_));
    std::vector<char> bytes;
    for (std::uint64_t left = num_points(); left > 0;) {
        const auto num = static_cast<std::size_t>(std::min(left, kMaxPoints));
        bytes.resize(num * kPoint_bytes);
        if (!stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
            fail_ply(file_.filename().string(), "PLY body is cut short");
        for (std::size_t i = 0; i < num; ++i) {
            Eigen::Vector3f p_world;
            types::Color color;
            std::memcpy(p_world.data(), &bytes[i * kPoint_bytes], 3 * sizeof(float));
            std::memcpy(color.data(), &bytes[i * kPoint_bytes + 3 * sizeof(float)], color.size());
            if (!p_world.allFinite()) fail_ply(file_.filename().string(), "a point is not finite");
            visit(p_world, color);
        }
        left -= num;
    }
}

}  // namespace divemesh::io
