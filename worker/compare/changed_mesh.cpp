#include "worker/compare/changed_mesh.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>

#include "worker/base/atomic_file.hpp"

namespace divemesh::compare {
namespace {

static_assert(std::endian::native == std::endian::little);

template <typename Value>
void put(std::string& bytes, const Value& value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
}

std::string header_of(const types::Mesh& mesh) {
    return "ply\nformat binary_little_endian 1.0\n"
           "comment divemesh; metres, frame of the earlier dive, z up; change since that dive\n"
           "element vertex " +
           std::to_string(mesh.vertices.size()) +
           "\nproperty float x\nproperty float y\nproperty float z\n"
           "property float nx\nproperty float ny\nproperty float nz\n"
           "property uchar red\nproperty uchar green\nproperty uchar blue\n"
           "property float distance\nproperty float lod95\nelement face " +
           std::to_string(mesh.triangles.size()) +
           "\nproperty list uchar int vertex_indices\nend_header\n";
}

}  // namespace

types::Color change_color(double change_m, double full_m) {
    if (std::isnan(change_m)) return {150, 150, 150};
    const double share = std::clamp(change_m / full_m, -1.0, 1.0);
    constexpr types::Color kWhite = {247, 247, 247};
    const types::Color end = share < 0.0 ? types::Color{178, 24, 43} : types::Color{33, 102, 172};
    types::Color color{};
    for (std::size_t i = 0; i < 3; ++i)
        color[i] = static_cast<std::uint8_t>(
            std::lround(kWhite[i] + std::abs(share) * (end[i] - kWhite[i])));
    return color;
}

void write_changed_mesh(const std::filesystem::path& file,
                        const types::Mesh& mesh,
                        const std::vector<M3c2Distance>& distances,
                        double full_m) {
    base::AtomicFile output(file);
    output.write(header_of(mesh));
    std::string record;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        record.clear();
        for (int axis = 0; axis < 3; ++axis) put(record, mesh.vertices[i][axis]);
        for (int axis = 0; axis < 3; ++axis) put(record, mesh.normals[i][axis]);
        const bool stable = distances[i].known() && !distances[i].significant();
        for (const std::uint8_t channel :
             change_color(stable ? 0.0 : static_cast<double>(distances[i].distance_m), full_m))
            put(record, channel);
        put(record, distances[i].distance_m);
        put(record, distances[i].lod95_m);
        output.write(record);
    }
    for (const auto& triangle : mesh.triangles) {
        record.clear();
        put(record, std::uint8_t{3});
        for (const std::uint32_t vertex : triangle) put(record, vertex);
        output.write(record);
    }
    output.commit();
}

}  // namespace divemesh::compare
