#include "worker/reef/height_grid.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::reef {
namespace {

// Tolerance, so that corners rounded to 0.01 mm still span a whole number of spacings.
constexpr double kSlack_m = 5e-5;
constexpr double kOnEdge = 1e-9;  // relative to a triangle's height

int first_at_or_after(double place) { return static_cast<int>(std::ceil(place - kOnEdge)); }
int last_at_or_before(double place) { return static_cast<int>(std::floor(place + kOnEdge)); }

void raise_under(const std::array<Eigen::Vector3d, 3>& corners, HeightGrid& grid) {
    const GridShape& shape = grid.shape;
    std::array<Eigen::Vector2d, 3> places;  // in spacings from the origin
    for (int i = 0; i < 3; ++i)
        places[i] = (corners[i].head<2>() - shape.origin_m) / shape.spacing_m;
    const auto [low_y, high_y] = std::minmax({places[0].y(), places[1].y(), places[2].y()});
    const auto [low_x, high_x] = std::minmax({places[0].x(), places[1].x(), places[2].x()});
    const int first_row = std::max(0, first_at_or_after(std::max(low_y, -1.0)));
    const int last_row =
        std::min(shape.num_rows - 1, last_at_or_before(std::min<double>(high_y, shape.num_rows)));
    const int first_column = std::max(0, first_at_or_after(std::max(low_x, -1.0)));
    const int last_column = std::min(
        shape.num_columns - 1, last_at_or_before(std::min<double>(high_x, shape.num_columns)));
    if (first_row > last_row || first_column > last_column) return;
    const Eigen::Vector2d ab = places[1] - places[0];
    const Eigen::Vector2d ac = places[2] - places[0];
    const double twice_area = ab.x() * ac.y() - ab.y() * ac.x();
    if (std::abs(twice_area) < 1e-12) return;
    for (int row = first_row; row <= last_row; ++row)
        for (int column = first_column; column <= last_column; ++column) {
            const double x = column - places[0].x();
            const double y = row - places[0].y();
            const double b = (x * ac.y() - y * ac.x()) / twice_area;
            const double c = (ab.x() * y - ab.y() * x) / twice_area;
            if (b < -kOnEdge || c < -kOnEdge || b + c > 1.0 + kOnEdge) continue;
            double& height = grid.heights_m[shape.index(column, row)];
            height = std::max(height,
                              corners[0].z() + b * (corners[1].z() - corners[0].z()) +
                                  c * (corners[2].z() - corners[0].z()));
        }
}

// Returns where a line of constant y crosses the outline, in ascending order.
std::vector<double> crossings(const Polygon& outline, double y) {
    std::vector<double> places;
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const Eigen::Vector2d& a = outline[i];
        const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
        if ((a.y() > y) == (b.y() > y)) continue;
        places.push_back(a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
    }
    std::sort(places.begin(), places.end());
    return places;
}

void mark_row(const GridShape& shape,
              int row,
              const std::vector<double>& places,
              std::vector<std::uint8_t>& within) {
    for (std::size_t i = 0; i + 1 < places.size(); i += 2) {
        const double first = (places[i] - kSlack_m - shape.origin_m.x()) / shape.spacing_m;
        const double last = (places[i + 1] + kSlack_m - shape.origin_m.x()) / shape.spacing_m;
        const int end = std::min(shape.num_columns - 1, static_cast<int>(std::floor(last)));
        for (int column = std::max(0, static_cast<int>(std::ceil(first))); column <= end; ++column)
            within[shape.index(column, row)] = 1;
    }
}

// Replaces each of `num` values, `stride` apart, by the sum over up to `radius` neighbours on
// either side.
void sum_around(double* values, int num, std::ptrdiff_t stride, int radius) {
    std::vector<double> before(static_cast<std::size_t>(num) + 1,
                               0.0);  // sum of all values before it
    for (int i = 0; i < num; ++i) before[i + 1] = before[i] + values[i * stride];
    for (int i = 0; i < num; ++i)
        values[i * stride] =
            before[std::min(num, i + radius + 1)] - before[std::max(0, i - radius)];
}

}  // namespace

GridShape grid_over(const Polygon& outline, double spacing_m) {
    Eigen::Vector2d low = outline[0];
    Eigen::Vector2d high = outline[0];
    for (const Eigen::Vector2d& corner : outline) {
        low = low.cwiseMin(corner);
        high = high.cwiseMax(corner);
    }
    GridShape shape;
    shape.origin_m = low;
    shape.spacing_m = spacing_m;
    const Eigen::Vector2d size = (high - low).array() + kSlack_m;
    shape.num_columns = static_cast<int>(std::floor(size.x() / spacing_m)) + 1;
    shape.num_rows = static_cast<int>(std::floor(size.y() / spacing_m)) + 1;
    return shape;
}

std::vector<std::uint8_t> nodes_within(const GridShape& shape, const Polygon& outline) {
    std::vector<std::uint8_t> within(shape.num_nodes(), 0);
    for (int row = 0; row < shape.num_rows; ++row)
        for (const double shift : {-kSlack_m, kSlack_m})
            mark_row(shape, row, crossings(outline, shape.y_m(row) + shift), within);
    return within;
}

HeightGrid sample_heights(const std::vector<Eigen::Vector3d>& vertices,
                          const Triangles& triangles,
                          const GridShape& shape) {
    HeightGrid grid{shape, std::vector<double>(shape.num_nodes(), kUnseen_m)};
    for (const auto& [a, b, c] : triangles)
        raise_under({vertices[a], vertices[b], vertices[c]}, grid);
    return grid;
}

HeightGrid every(const HeightGrid& grid, int step) {
    if (step == 1) return grid;
    HeightGrid coarse;
    coarse.shape = grid.shape;
    coarse.shape.spacing_m *= step;
    coarse.shape.num_columns = (grid.shape.num_columns - 1) / step + 1;
    coarse.shape.num_rows = (grid.shape.num_rows - 1) / step + 1;
    coarse.heights_m.reserve(coarse.shape.num_nodes());
    for (int row = 0; row < coarse.shape.num_rows; ++row)
        for (int column = 0; column < coarse.shape.num_columns; ++column)
            coarse.heights_m.push_back(grid.at(column * step, row * step));
    return coarse;
}

HeightGrid blurred(const HeightGrid& grid, double side_m) {
    const GridShape& shape = grid.shape;
    const int radius = static_cast<int>(std::lround(0.5 * side_m / shape.spacing_m));
    std::vector<double> sums(shape.num_nodes());
    std::vector<double> nums(shape.num_nodes());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const bool is_seen = grid.heights_m[i] > kUnseen_m;
        sums[i] = is_seen ? grid.heights_m[i] : 0.0;
        nums[i] = is_seen ? 1.0 : 0.0;
    }
    for (std::vector<double>* values : {&sums, &nums}) {
        for (int row = 0; row < shape.num_rows; ++row)
            sum_around(values->data() + shape.index(0, row), shape.num_columns, 1, radius);
        for (int column = 0; column < shape.num_columns; ++column)
            sum_around(values->data() + column, shape.num_rows, shape.num_columns, radius);
    }
    HeightGrid out = grid;
    for (std::size_t i = 0; i < sums.size(); ++i)
        if (grid.heights_m[i] > kUnseen_m) out.heights_m[i] = sums[i] / nums[i];
    return out;
}

}  // namespace divemesh::reef
