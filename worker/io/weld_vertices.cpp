#include "worker/io/weld_vertices.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <unordered_map>

namespace divemesh::io {
namespace {

using Place = std::array<float, 6>;  // position and normal

struct PlaceHash {
    std::size_t operator()(const Place& place) const {
        return std::hash<std::string_view>()(
            {reinterpret_cast<const char*>(place.data()), sizeof place});
    }
};

// Adding 0 makes one value of 0 and -0, which are equal but differ in their bits.
Place place_of(const types::Mesh& mesh, std::size_t vertex) {
    Place place{};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = static_cast<Eigen::Index>(i);
        place[i] = mesh.vertices[vertex][axis] + 0.0F;
        if (!mesh.normals.empty()) place[3 + i] = mesh.normals[vertex][axis] + 0.0F;
    }
    return place;
}

}  // namespace

void weld_vertices(types::Mesh& mesh) {
    std::unordered_map<Place, std::uint32_t, PlaceHash> vertex_at;
    vertex_at.reserve(mesh.vertices.size());
    std::vector<std::uint32_t> welded(mesh.vertices.size());
    std::uint32_t num = 0;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        const auto [found, is_new] = vertex_at.try_emplace(place_of(mesh, i), num);
        const std::uint32_t target = found->second;
        welded[i] = target;
        if (is_new) {
            ++num;
            mesh.vertices[target] = mesh.vertices[i];
            if (!mesh.normals.empty()) mesh.normals[target] = mesh.normals[i];
            if (!mesh.colors.empty()) mesh.colors[target] = mesh.colors[i];
        } else if (!mesh.colors.empty()) {
            mesh.colors[target] = std::min(mesh.colors[target], mesh.colors[i]);
        }
    }
    mesh.vertices.resize(num);
    if (!mesh.normals.empty()) mesh.normals.resize(num);
    if (!mesh.colors.empty()) mesh.colors.resize(num);
    for (auto& triangle : mesh.triangles)
        for (std::uint32_t& vertex : triangle) vertex = welded[vertex];
}

}  // namespace divemesh::io
