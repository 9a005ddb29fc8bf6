#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "worker/reef/area_set.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::reef {

using HeightOf = std::function<double(double x, double y)>;

// Returns a height field over [0, size] x [0, size], m, with square cells of side `cell` cut into
// two triangles.
inline types::Mesh sheet(double size, double cell, const HeightOf& height) {
    types::Mesh mesh;
    const auto num = static_cast<std::uint32_t>(std::lround(size / cell));
    for (std::uint32_t y = 0; y <= num; ++y)
        for (std::uint32_t x = 0; x <= num; ++x)
            mesh.vertices.push_back(
                Eigen::Vector3d(cell * x, cell * y, height(cell * x, cell * y)).cast<float>());
    for (std::uint32_t y = 0; y < num; ++y)
        for (std::uint32_t x = 0; x < num; ++x) {
            const std::uint32_t corner = y * (num + 1) + x;
            mesh.triangles.push_back({corner, corner + 1, corner + num + 1});
            mesh.triangles.push_back({corner + 1, corner + num + 2, corner + num + 1});
        }
    return mesh;
}

inline void add_triangle(types::Mesh& mesh,
                         const Eigen::Vector3d& a,
                         const Eigen::Vector3d& b,
                         const Eigen::Vector3d& c) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Eigen::Vector3d& corner : {a, b, c}) mesh.vertices.push_back(corner.cast<float>());
    mesh.triangles.push_back({first, first + 1, first + 2});
}

inline void add_face(types::Mesh& mesh, const std::array<Eigen::Vector3d, 4>& corners) {
    add_triangle(mesh, corners[0], corners[1], corners[2]);
    add_triangle(mesh, corners[0], corners[2], corners[3]);
}

// Adds a box's top and its four walls from z = 0, without a bottom.
inline void add_box(types::Mesh& mesh,
                    const Eigen::Vector2d& low,
                    const Eigen::Vector2d& high,
                    double h) {
    const std::array<Eigen::Vector2d, 4> base = {
        low, {high.x(), low.y()}, high, {low.x(), high.y()}};
    std::array<Eigen::Vector3d, 4> top;
    for (int i = 0; i < 4; ++i) top[i] = {base[i].x(), base[i].y(), h};
    add_face(mesh, top);
    for (int i = 0; i < 4; ++i) {
        const Eigen::Vector3d a(base[i].x(), base[i].y(), 0.0);
        const Eigen::Vector3d b(base[(i + 1) % 4].x(), base[(i + 1) % 4].y(), 0.0);
        add_face(mesh, {a, b, top[(i + 1) % 4], top[i]});
    }
}

inline Area quadrat(const std::string& name, double low, double high) {
    Area area;
    area.name = name;
    area.points = {{low, low, 0.0}, {high, low, 0.0}, {high, high, 0.0}, {low, high, 0.0}};
    return area;
}

// Returns the entry of a metric; null if it is missing.
inline nlohmann::json metric_of(const nlohmann::json& measured,
                                const std::string& area,
                                const std::string& metric,
                                double resolution_m = 0.0) {
    for (const nlohmann::json& entry : measured["figures"])
        if (entry["area"] == area && entry["figure"] == metric &&
            (resolution_m == 0.0 ||
             std::abs(entry.value("resolution_m", 0.0) - resolution_m) < 1e-9))
            return entry;
    return nullptr;
}

}  // namespace divemesh::reef
