#include "tests/bench/square_truth.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace divemesh::bench {
namespace {

using Corners = std::vector<Eigen::Vector3d>;

double area_m2(const Corners& corners) {
    Eigen::Vector3d twice = Eigen::Vector3d::Zero();
    for (std::size_t i = 2; i < corners.size(); ++i)
        twice += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
    return 0.5 * twice.norm();
}

// Returns the part of a convex polygon with sign * p[axis] >= sign * limit.
Corners cut(const Corners& corners, int axis, double sign, double limit) {
    Corners kept;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Eigen::Vector3d& a = corners[i];
        const Eigen::Vector3d& b = corners[(i + 1) % corners.size()];
        const double inside_a = sign * (a[axis] - limit);
        const double inside_b = sign * (b[axis] - limit);
        if (inside_a >= 0.0) kept.push_back(a);
        if ((inside_a >= 0.0) != (inside_b >= 0.0))
            kept.emplace_back(a + inside_a / (inside_a - inside_b) * (b - a));
    }
    return kept;
}

// Calls visit(center, area_m2) for parts of a triangle with sides of a centimetre at most.
template <typename Visit>
void for_each_part(const std::array<Eigen::Vector3d, 3>& triangle, const Visit& visit) {
    constexpr double kMaxSide_m = 0.01;
    const auto& [a, b, c] = triangle;
    if (std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()}) <= kMaxSide_m) {
        visit(Eigen::Vector3d((a + b + c) / 3.0), area_m2({a, b, c}));
        return;
    }
    const Eigen::Vector3d ab = 0.5 * (a + b);
    const Eigen::Vector3d bc = 0.5 * (b + c);
    const Eigen::Vector3d ca = 0.5 * (c + a);
    for_each_part({a, ab, ca}, visit);
    for_each_part({ab, b, bc}, visit);
    for_each_part({ca, bc, c}, visit);
    for_each_part({ab, bc, ca}, visit);
}

bool is_seen(const Eigen::Vector3d& point,
             const evaluation::SurfaceIndex& surface,
             const std::vector<Eigen::Vector3d>& cameras) {
    constexpr double kOwnSurface_m = 0.0005;
    return std::any_of(cameras.begin(), cameras.end(), [&](const Eigen::Vector3d& camera) {
        const double distance_m = (camera - point).norm();
        const Eigen::Vector3d direction = (camera - point) / distance_m;
        const auto hit = surface.first_hit_m((point + kOwnSurface_m * direction).cast<float>(),
                                             direction.cast<float>());
        return !hit || *hit > distance_m;
    });
}

Eigen::Vector3d point_at(const SquareHeights& heights, double spacing_m, int column, int row) {
    const int step = static_cast<int>(std::lround(spacing_m * SquareHeights::kPerMetre));
    return {column * spacing_m, row * spacing_m, heights.at(column * step, row * step)};
}

}  // namespace

double SquareHeights::share_known() const {
    const auto num = std::count_if(
        heights_m.begin(), heights_m.end(), [](double height) { return !std::isnan(height); });
    return static_cast<double>(num) / static_cast<double>(heights_m.size());
}

SquareHeights heights_of(const Square& square,
                         const evaluation::SurfaceIndex& surface,
                         double above_m) {
    SquareHeights result;
    result.num_nodes = 1 + static_cast<int>(std::lround(square.side_m * SquareHeights::kPerMetre));
    for (int row = 0; row < result.num_nodes; ++row)
        for (int column = 0; column < result.num_nodes; ++column) {
            const Eigen::Vector2d place =
                square.corner_m + Eigen::Vector2d(column, row) / SquareHeights::kPerMetre;
            const auto down =
                surface.first_hit_m(Eigen::Vector3d(place.x(), place.y(), above_m).cast<float>(),
                                    -Eigen::Vector3f::UnitZ());
            result.heights_m.push_back(down ? above_m - *down : std::nan(""));
        }
    return result;
}

std::optional<double> true_rugosity(const SquareHeights& heights, double spacing_m) {
    const int step = static_cast<int>(std::lround(spacing_m * SquareHeights::kPerMetre));
    const int num_cells = (heights.num_nodes - 1) / step;
    double surface_m2 = 0.0, planar_m2 = 0.0;
    for (int row = 0; row < num_cells; ++row)
        for (int column = 0; column < num_cells; ++column) {
            const Eigen::Vector3d a = point_at(heights, spacing_m, column, row);
            const Eigen::Vector3d b = point_at(heights, spacing_m, column + 1, row);
            const Eigen::Vector3d c = point_at(heights, spacing_m, column + 1, row + 1);
            const Eigen::Vector3d d = point_at(heights, spacing_m, column, row + 1);
            const double both =
                area_m2({a, b, c}) + area_m2({a, c, d}) + area_m2({a, b, d}) + area_m2({b, c, d});
            if (std::isnan(both)) continue;
            surface_m2 += 0.5 * both;
            planar_m2 += spacing_m * spacing_m;
        }
    if (planar_m2 == 0.0) return std::nullopt;
    return surface_m2 / planar_m2;
}

std::optional<HeightRange> true_range(const SquareHeights& heights) {
    std::optional<HeightRange> range;
    for (const double height : heights.heights_m) {
        if (std::isnan(height)) continue;
        if (!range) range = {height, height};
        range->low_m = std::min(range->low_m, height);
        range->high_m = std::max(range->high_m, height);
    }
    return range;
}

double true_volume_m3(const SquareHeights& heights, double plane_z_m) {
    double sum_m = 0.0, num = 0.0;
    const int last = heights.num_nodes - 1;
    for (int row = 0; row <= last; ++row)
        for (int column = 0; column <= last; ++column) {
            const double height = heights.at(column, row);
            if (std::isnan(height)) continue;
            const double share = (row % last == 0 ? 0.5 : 1.0) * (column % last == 0 ? 0.5 : 1.0);
            sum_m += share * (height - plane_z_m);
            num += share;
        }
    const double side_m = static_cast<double>(last) / SquareHeights::kPerMetre;
    return sum_m / num * side_m * side_m;
}

double true_slope_deg(const SquareHeights& heights) {
    std::vector<Eigen::Vector3d> points;
    for (int row = 0; row < heights.num_nodes; ++row)
        for (int column = 0; column < heights.num_nodes; ++column)
            if (const double height = heights.at(column, row); !std::isnan(height))
                points.emplace_back(static_cast<double>(column) / SquareHeights::kPerMetre,
                                    static_cast<double>(row) / SquareHeights::kPerMetre,
                                    height);
    Eigen::MatrixX3d places(points.size(), 3);
    Eigen::VectorXd tops(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        places.row(static_cast<Eigen::Index>(i)) << points[i].x(), points[i].y(), 1.0;
        tops[static_cast<Eigen::Index>(i)] = points[i].z();
    }
    const Eigen::Vector3d plane = places.colPivHouseholderQr().solve(tops);
    return std::atan(plane.head<2>().norm()) * 180.0 / std::numbers::pi;
}

double true_surface_area_m2(const Square& square,
                            const types::Mesh& mesh,
                            const evaluation::SurfaceIndex& surface,
                            const std::vector<Eigen::Vector3d>& cameras) {
    double sum_m2 = 0.0;
    for (const auto& triangle : mesh.triangles) {
        Corners corners;
        for (const std::uint32_t index : triangle)
            corners.push_back(mesh.vertices[index].cast<double>());
        for (const int axis : {0, 1}) {
            corners = cut(corners, axis, 1.0, square.corner_m[axis]);
            corners = cut(corners, axis, -1.0, square.corner_m[axis] + square.side_m);
        }
        for (std::size_t i = 2; i < corners.size(); ++i)
            for_each_part({corners[0], corners[i - 1], corners[i]},
                          [&](const Eigen::Vector3d& center, double part_m2) {
                              if (is_seen(center, surface, cameras)) sum_m2 += part_m2;
                          });
    }
    return sum_m2;
}

}  // namespace divemesh::bench
