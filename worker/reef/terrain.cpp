#include "worker/reef/terrain.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

namespace divemesh::reef {
namespace {

bool is_window_seen(const HeightGrid& grid, int column, int row) {
    for (int y = row - 1; y <= row + 1; ++y)
        for (int x = column - 1; x <= column + 1; ++x)
            if (!grid.is_seen(x, y)) return false;
    return true;
}

Eigen::Vector2d gradient(const HeightGrid& grid, int column, int row) {
    const auto h = [&](int x, int y) { return grid.at(column + x, row + y); };
    const double eight = 8.0 * grid.shape.spacing_m;
    return {(h(1, -1) + 2.0 * h(1, 0) + h(1, 1) - h(-1, -1) - 2.0 * h(-1, 0) - h(-1, 1)) / eight,
            (h(-1, 1) + 2.0 * h(0, 1) + h(1, 1) - h(-1, -1) - 2.0 * h(0, -1) - h(1, -1)) / eight};
}

double curvature(const HeightGrid& grid, int column, int row) {
    const double around = grid.at(column - 1, row) + grid.at(column + 1, row) +
                          grid.at(column, row - 1) + grid.at(column, row + 1);
    return (4.0 * grid.at(column, row) - around) / (grid.shape.spacing_m * grid.shape.spacing_m);
}

// Returns the normals of the windows around each node; zero if part of a window is unseen.
std::vector<Eigen::Vector3d> normals_of(const HeightGrid& grid) {
    std::vector<Eigen::Vector3d> normals(grid.shape.num_nodes(), Eigen::Vector3d::Zero());
    for (int row = 1; row + 1 < grid.shape.num_rows; ++row)
        for (int column = 1; column + 1 < grid.shape.num_columns; ++column) {
            if (!is_window_seen(grid, column, row)) continue;
            const Eigen::Vector2d slope = gradient(grid, column, row);
            normals[grid.shape.index(column, row)] =
                Eigen::Vector3d(-slope.x(), -slope.y(), 1.0).normalized();
        }
    return normals;
}

std::optional<double> mean_vrm(const HeightGrid& grid,
                               const std::vector<Eigen::Vector3d>& normals) {
    double sum = 0.0;
    std::int64_t num = 0;
    for (int row = 2; row + 2 < grid.shape.num_rows; ++row)
        for (int column = 2; column + 2 < grid.shape.num_columns; ++column) {
            Eigen::Vector3d resultant = Eigen::Vector3d::Zero();
            bool is_known = true;
            for (int y = row - 1; y <= row + 1; ++y)
                for (int x = column - 1; x <= column + 1; ++x) {
                    const Eigen::Vector3d& normal = normals[grid.shape.index(x, y)];
                    is_known = is_known && normal.z() > 0.0;
                    resultant += normal;
                }
            if (!is_known) continue;
            sum += 1.0 - resultant.norm() / 9.0;
            ++num;
        }
    if (num == 0) return std::nullopt;
    return sum / static_cast<double>(num);
}

}  // namespace

std::optional<Terrain> terrain(const HeightGrid& grid) {
    const std::vector<Eigen::Vector3d> normals = normals_of(grid);
    const auto vrm = mean_vrm(grid, normals);
    if (!vrm) return std::nullopt;
    Terrain terrain;
    terrain.vrm = *vrm;
    double squares = 0.0;
    double num = 0.0;
    for (int row = 1; row + 1 < grid.shape.num_rows; ++row)
        for (int column = 1; column + 1 < grid.shape.num_columns; ++column) {
            const Eigen::Vector3d& normal = normals[grid.shape.index(column, row)];
            if (normal.z() <= 0.0) continue;
            terrain.mean_slope += std::acos(normal.z());
            const double here = curvature(grid, column, row);
            terrain.mean_curvature += here;
            squares += here * here;
            num += 1.0;
        }
    terrain.mean_slope /= num;
    terrain.mean_curvature /= num;
    terrain.curvature_deviation =
        std::sqrt(std::max(0.0, squares / num - terrain.mean_curvature * terrain.mean_curvature));
    return terrain;
}

std::optional<Eigen::Vector3d> mean_normal(const HeightGrid& grid) {
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (int row = 0; row < grid.shape.num_rows; ++row)
        for (int column = 0; column < grid.shape.num_columns; ++column) {
            if (!grid.is_seen(column, row)) continue;
            const Eigen::Vector3d place(
                column * grid.shape.spacing_m, row * grid.shape.spacing_m, 1.0);
            products += place * place.transpose();
            right += place * grid.at(column, row);
        }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(products);
    if (!(solver.eigenvalues()[0] > 1e-12 * solver.eigenvalues()[2])) return std::nullopt;
    const Eigen::Vector3d plane = products.ldlt().solve(right);
    return Eigen::Vector3d(-plane.x(), -plane.y(), 1.0).normalized();
}

}  // namespace divemesh::reef
