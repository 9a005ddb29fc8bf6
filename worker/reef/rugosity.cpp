#include "worker/reef/rugosity.hpp"

#include <array>
#include <cmath>

#include "worker/reef/complexity_relation.hpp"
#include "worker/reef/fractal_dimension.hpp"

namespace divemesh::reef {
namespace {

// Returns twice the area of a triangle whose legs are one spacing long and rise by these heights.
double twice_area(double spacing_m, double rise_x, double rise_y) {
    const double s = spacing_m * spacing_m;
    return std::sqrt(s * (s + rise_x * rise_x + rise_y * rise_y));
}

GridArea area_of_cell(const std::array<double, 4>& corners, double s) {  // 00 10 11 01
    int num_seen = 0;
    double twice = 0.0;  // of the triangles at each corner with its two neighbours
    int num_triangles = 0;
    for (int i = 0; i < 4; ++i) {
        const double here = corners[i];
        const double before = corners[(i + 3) % 4];
        const double after = corners[(i + 1) % 4];
        if (here > kUnseen_m) ++num_seen;
        if (!(here > kUnseen_m && before > kUnseen_m && after > kUnseen_m)) continue;
        twice += twice_area(s, after - here, before - here);
        ++num_triangles;
    }
    if (num_triangles == 0) return {};
    const double share = num_seen == 4 ? 1.0 : 0.5;  // four triangles: a cell split both ways
    return {0.5 * twice * (num_seen == 4 ? 0.5 : 1.0), share * s * s};
}

}  // namespace

GridArea grid_area(const HeightGrid& grid) {
    GridArea sum;
    for (int row = 0; row + 1 < grid.shape.num_rows; ++row)
        for (int column = 0; column + 1 < grid.shape.num_columns; ++column) {
            const GridArea cell = area_of_cell({grid.at(column, row),
                                                grid.at(column + 1, row),
                                                grid.at(column + 1, row + 1),
                                                grid.at(column, row + 1)},
                                               grid.shape.spacing_m);
            sum.surface_m2 += cell.surface_m2;
            sum.planar_m2 += cell.planar_m2;
        }
    return sum;
}

std::optional<double> rugosity(const HeightGrid& grid) {
    const GridArea area = grid_area(grid);
    if (area.planar_m2 <= 0.0) return std::nullopt;
    return area.surface_m2 / area.planar_m2;
}

std::optional<double> rugosity_by_height_variation(const HeightGrid& grid, double side_m) {
    const std::vector<double> ranges = height_ranges(grid, side_m);
    if (ranges.empty()) return std::nullopt;
    double sum = 0.0;
    for (const double range : ranges) sum += rugosity_of_height_range(range, side_m);
    return sum / static_cast<double>(ranges.size());
}

std::optional<double> chain_rugosity(const std::vector<ProfilePoint>& profile) {
    double chain = 0.0;
    double straight = 0.0;
    for (std::size_t i = 1; i < profile.size(); ++i) {
        const ProfilePoint& a = profile[i - 1];
        const ProfilePoint& b = profile[i];
        if (!(a.height_m > kUnseen_m && b.height_m > kUnseen_m)) continue;
        const double along = b.along_m - a.along_m;
        straight += along;
        chain += std::hypot(along, b.height_m - a.height_m);
    }
    if (straight <= 0.0) return std::nullopt;
    return chain / straight;
}

}  // namespace divemesh::reef
