#include "worker/reef/fractal_dimension.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace divemesh::reef {
namespace {

constexpr double kMinSeenShare = 0.9;  // of a square
constexpr std::size_t kMinScales = 3;

// `bounds`: columns [first, last], rows [first, last].
std::optional<double> range_within(const HeightGrid& grid, const std::array<int, 4>& bounds) {
    double low = -kUnseen_m;
    double high = kUnseen_m;
    int num_seen = 0;
    for (int row = bounds[2]; row <= bounds[3]; ++row)
        for (int column = bounds[0]; column <= bounds[1]; ++column) {
            if (!grid.is_seen(column, row)) continue;
            ++num_seen;
            low = std::min(low, grid.at(column, row));
            high = std::max(high, grid.at(column, row));
        }
    const int num = (bounds[1] - bounds[0] + 1) * (bounds[3] - bounds[2] + 1);
    if (num_seen < kMinSeenShare * num) return std::nullopt;
    return high - low;
}

// Returns the number of cubes of this side, from the lowest corner, that contain a sample.
std::size_t num_cubes(const HeightGrid& grid, const Eigen::Vector3d& low, double side_m) {
    std::vector<std::uint64_t> cubes;  // 21 bits per axis
    for (int row = 0; row < grid.shape.num_rows; ++row)
        for (int column = 0; column < grid.shape.num_columns; ++column) {
            if (!grid.is_seen(column, row)) continue;
            const Eigen::Vector3d place(
                grid.shape.x_m(column), grid.shape.y_m(row), grid.at(column, row));
            const Eigen::Vector3d cube = (place - low) / side_m;
            cubes.push_back(static_cast<std::uint64_t>(cube.x()) << 42U |
                            static_cast<std::uint64_t>(cube.y()) << 21U |
                            static_cast<std::uint64_t>(cube.z()));
        }
    std::sort(cubes.begin(), cubes.end());
    return static_cast<std::size_t>(
        std::distance(cubes.begin(), std::unique(cubes.begin(), cubes.end())));
}

struct Extent {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(-kUnseen_m);
    Eigen::Vector3d high = Eigen::Vector3d::Constant(kUnseen_m);
};

Extent extent_of(const HeightGrid& grid) {
    Extent extent;
    for (int row = 0; row < grid.shape.num_rows; ++row)
        for (int column = 0; column < grid.shape.num_columns; ++column) {
            if (!grid.is_seen(column, row)) continue;
            const Eigen::Vector3d place(
                grid.shape.x_m(column), grid.shape.y_m(row), grid.at(column, row));
            extent.low = extent.low.cwiseMin(place);
            extent.high = extent.high.cwiseMax(place);
        }
    return extent;
}

}  // namespace

std::vector<double> height_ranges(const HeightGrid& grid, double side_m) {
    const int steps = static_cast<int>(std::lround(side_m / grid.shape.spacing_m));
    std::vector<double> ranges;
    if (steps < 1) return ranges;
    for (int row = 0; row + steps < grid.shape.num_rows; row += steps)
        for (int column = 0; column + steps < grid.shape.num_columns; column += steps)
            if (const auto range = range_within(grid, {column, column + steps, row, row + steps}))
                ranges.push_back(*range);
    return ranges;
}

std::vector<double> halved_scales(const HeightGrid& grid, double min_m) {
    const int shorter = std::min(grid.shape.num_columns, grid.shape.num_rows) - 1;
    std::vector<double> scales;
    for (double side = shorter * grid.shape.spacing_m; side >= min_m * (1.0 - 1e-9); side *= 0.5)
        scales.push_back(side);
    return scales;
}

std::optional<double> log_log_slope(const std::vector<double>& x, const std::vector<double>& y) {
    if (x.size() < kMinScales) return std::nullopt;
    double mean_x = 0.0;
    double mean_y = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        mean_x += std::log(x[i]) / static_cast<double>(x.size());
        mean_y += std::log(y[i]) / static_cast<double>(x.size());
    }
    double products = 0.0;
    double squares = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double dx = std::log(x[i]) - mean_x;
        products += dx * (std::log(y[i]) - mean_y);
        squares += dx * dx;
    }
    return products / squares;
}

std::optional<double> fractal_dimension_by_height_variation(const HeightGrid& grid, double min_m) {
    std::vector<double> scales;
    std::vector<double> means;
    for (const double side : halved_scales(grid, min_m)) {
        const std::vector<double> ranges = height_ranges(grid, side);
        double sum = 0.0;
        for (const double range : ranges) sum += range;
        if (!(sum > 0.0)) continue;
        scales.push_back(std::round(side / grid.shape.spacing_m) * grid.shape.spacing_m);
        means.push_back(sum / static_cast<double>(ranges.size()));
    }
    const auto slope = log_log_slope(scales, means);
    if (!slope) return std::nullopt;
    return 3.0 - *slope;
}

std::optional<double> fractal_dimension_by_cubes(const HeightGrid& grid, double min_m) {
    const Extent extent = extent_of(grid);
    const double longest = (extent.high - extent.low).maxCoeff();
    if (!(longest > 0.0)) return std::nullopt;
    // Samples on the far sides lie within the largest cube.
    const Eigen::Vector3d low = extent.low.array() - 0.5 * grid.shape.spacing_m;
    std::vector<double> sides;
    std::vector<double> counts;
    for (double side = longest + grid.shape.spacing_m; side >= min_m; side *= 0.5) {
        sides.push_back(side);
        counts.push_back(static_cast<double>(num_cubes(grid, low, side)));
    }
    const auto slope = log_log_slope(sides, counts);
    if (!slope) return std::nullopt;
    return -*slope;
}

}  // namespace divemesh::reef
