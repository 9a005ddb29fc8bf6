#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>

#include "worker/types/mesh.hpp"

namespace divemesh::synthetic {

using HeightOf = std::function<double(double x, double y)>;

// Returns the height of ground with humps of 0.3 to 2 m length, about 0.1 m high, m; different for
// each seed.
inline HeightOf rough_ground(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0.0, 1.0);
    struct Wave {
        double x, y, phase, height;
    };
    std::vector<Wave> waves;
    for (int i = 0; i < 24; ++i) {
        const double length_m = 0.3 + 1.7 * any(random);
        const double heading = 6.283 * any(random);
        const double number = 6.283 / length_m;
        waves.push_back({number * std::cos(heading),
                         number * std::sin(heading),
                         6.283 * any(random),
                         0.025 * length_m});
    }
    return [waves](double x, double y) {
        double height = 0.0;
        for (const Wave& w : waves) height += w.height * std::sin(w.x * x + w.y * y + w.phase);
        return height;
    };
}

// Returns a height field of size 2 * half_x by 2 * half_y around the origin, with a vertex every
// `step_m`, moved along its normal by noise of `sigma_m`.
inline types::Mesh ground_mesh(const HeightOf& height,
                               double half_x_m,
                               double half_y_m,
                               double step_m,
                               double sigma_m,
                               unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, sigma_m > 0.0 ? sigma_m : 1.0);
    types::Mesh mesh;
    const auto columns = static_cast<std::uint32_t>(2.0 * half_x_m / step_m) + 1U;
    const auto rows = static_cast<std::uint32_t>(2.0 * half_y_m / step_m) + 1U;
    for (std::uint32_t row = 0; row < rows; ++row)
        for (std::uint32_t column = 0; column < columns; ++column) {
            const double x = -half_x_m + step_m * column;
            const double y = -half_y_m + step_m * row;
            constexpr double kSmall_m = 1e-4;
            const Eigen::Vector3d normal =
                Eigen::Vector3d(-(height(x + kSmall_m, y) - height(x - kSmall_m, y)),
                                -(height(x, y + kSmall_m) - height(x, y - kSmall_m)),
                                2.0 * kSmall_m)
                    .normalized();
            const double off_m = sigma_m > 0.0 ? noise(random) : 0.0;
            const Eigen::Vector3d p = Eigen::Vector3d(x, y, height(x, y)) + off_m * normal;
            mesh.vertices.push_back(p.cast<float>());
            mesh.normals.push_back(normal.cast<float>());
            mesh.sigma_m.push_back(static_cast<float>(sigma_m));
        }
    for (std::uint32_t row = 0; row + 1 < rows; ++row)
        for (std::uint32_t column = 0; column + 1 < columns; ++column) {
            const std::uint32_t i = row * columns + column;
            mesh.triangles.push_back({i, i + 1, i + columns});
            mesh.triangles.push_back({i + 1, i + columns + 1, i + columns});
        }
    return mesh;
}

inline types::Mesh moved(types::Mesh mesh, const Eigen::Isometry3d& T) {
    for (Eigen::Vector3f& p : mesh.vertices) p = (T * p.cast<double>()).cast<float>();
    for (Eigen::Vector3f& n : mesh.normals) n = (T.linear() * n.cast<double>()).cast<float>();
    return mesh;
}

// Returns both surfaces in one mesh, those of `b` after those of `a`.
inline types::Mesh joined(types::Mesh a, const types::Mesh& b) {
    const auto first = static_cast<std::uint32_t>(a.vertices.size());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    a.normals.insert(a.normals.end(), b.normals.begin(), b.normals.end());
    a.sigma_m.insert(a.sigma_m.end(), b.sigma_m.begin(), b.sigma_m.end());
    for (const auto& [i, j, k] : b.triangles)
        a.triangles.push_back({i + first, j + first, k + first});
    return a;
}

}  // namespace divemesh::synthetic
