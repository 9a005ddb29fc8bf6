#include "worker/reef/displace_steps.hpp"

#include <algorithm>
#include <cmath>

#include "worker/reef/surface_noise.hpp"

namespace divemesh::reef {
namespace {

constexpr double kPerAlike = 4.0;  // places of a field for each length over which it is alike

// A smooth field of numbers of variance 1 over a grid, from fewer places than the grid has nodes.
class GridField {
public:
    GridField(const GridShape& shape, double alike_m, std::uint64_t seed)
        : spacing_m_(std::max(shape.spacing_m, alike_m / kPerAlike)),
          num_columns_(2 + static_cast<int>(shape.num_columns * shape.spacing_m / spacing_m_)) {
        const int num_rows = 2 + static_cast<int>(shape.num_rows * shape.spacing_m / spacing_m_);
        const NoiseField noise(alike_m, seed);
        for (int row = 0; row < num_rows; ++row)
            for (int column = 0; column < num_columns_; ++column)
                values_.push_back(noise.at({shape.origin_m.x() + column * spacing_m_,
                                            shape.origin_m.y() + row * spacing_m_,
                                            0.0}));
    }

    // Returns the value at a distance from the grid's origin, linear between places.
    double at(double x_m, double y_m) const {
        const int column = static_cast<int>(x_m / spacing_m_);
        const int row = static_cast<int>(y_m / spacing_m_);
        const double u = x_m / spacing_m_ - column;
        const double v = y_m / spacing_m_ - row;
        const double* low = &values_[static_cast<std::size_t>(row) * num_columns_ + column];
        const double* high = low + num_columns_;
        return (1.0 - v) * ((1.0 - u) * low[0] + u * low[1]) +
               v * ((1.0 - u) * high[0] + u * high[1]);
    }

private:
    double spacing_m_;
    int num_columns_;
    std::vector<double> values_;
};

}  // namespace

HeightGrid with_steps_displaced(const HeightGrid& grid, const StepDisplacement& displacement) {
    const GridShape& shape = grid.shape;
    const GridField along_x(shape, displacement.alike_m, 2 * displacement.seed);
    const GridField along_y(shape, displacement.alike_m, 2 * displacement.seed + 1);
    const double steps_per_sigma = displacement.deviation_m / shape.spacing_m;
    HeightGrid moved = grid;
    for (int row = 0; row < shape.num_rows; ++row)
        for (int column = 0; column < shape.num_columns; ++column) {
            if (!grid.is_seen(column, row)) continue;
            const double x_m = column * shape.spacing_m;
            const double y_m = row * shape.spacing_m;
            const int columns =
                static_cast<int>(std::lround(steps_per_sigma * along_x.at(x_m, y_m)));
            const int rows = static_cast<int>(std::lround(steps_per_sigma * along_y.at(x_m, y_m)));
            const int from_column = std::clamp(column + columns, 0, shape.num_columns - 1);
            const int from_row = std::clamp(row + rows, 0, shape.num_rows - 1);
            if (!grid.is_seen(from_column, from_row)) continue;
            const double distance_m =
                shape.spacing_m * std::hypot(from_column - column, from_row - row);
            const double height = grid.at(from_column, from_row);
            if (std::abs(height - grid.at(column, row)) > distance_m)
                moved.heights_m[shape.index(column, row)] = height;
        }
    return moved;
}

}  // namespace divemesh::reef
