#include "worker/reef/heights.hpp"

#include <algorithm>

namespace divemesh::reef {
namespace {

// Returns the sum of `value_of` each seen height times its share of a spacing square.
template <typename ValueOf>
double sum_over_squares(const HeightGrid& grid, const ValueOf& value_of) {
    const GridShape& shape = grid.shape;
    double sum = 0.0;
    for (int row = 0; row < shape.num_rows; ++row)
        for (int column = 0; column < shape.num_columns; ++column) {
            if (!grid.is_seen(column, row)) continue;
            double share = 1.0;
            if (row == 0 || row + 1 == shape.num_rows) share *= 0.5;
            if (column == 0 || column + 1 == shape.num_columns) share *= 0.5;
            sum += share * value_of(grid.at(column, row));
        }
    return sum * shape.spacing_m * shape.spacing_m;
}

}  // namespace

std::optional<double> height_range(const HeightGrid& grid) {
    double low = -kUnseen_m;
    double high = kUnseen_m;
    for (const double height : grid.heights_m) {
        if (!(height > kUnseen_m)) continue;
        low = std::min(low, height);
        high = std::max(high, height);
    }
    if (!(low <= high)) return std::nullopt;
    return high - low;
}

double planar_area_m2(const HeightGrid& grid) {
    return sum_over_squares(grid, [](double) { return 1.0; });
}

double volume_over_plane(const HeightGrid& grid) {
    return sum_over_squares(grid, [](double height_m) { return height_m; });
}

}  // namespace divemesh::reef
