#include "worker/reef/fill_gaps.hpp"

#include <algorithm>
#include <vector>

namespace divemesh::reef {
namespace {

struct Level {
    int num_columns = 0;
    int num_rows = 0;
    std::vector<double> heights_m;
    std::vector<double> weights;  // 0: unseen; at most 1

    std::size_t index(int column, int row) const {
        return static_cast<std::size_t>(row) * num_columns + column;
    }
};

Level finest(const HeightGrid& grid) {
    Level level{grid.shape.num_columns, grid.shape.num_rows, grid.heights_m, {}};
    level.weights.reserve(level.heights_m.size());
    for (double& height : level.heights_m) {
        level.weights.push_back(height > kUnseen_m ? 1.0 : 0.0);
        if (!(height > kUnseen_m)) height = 0.0;
    }
    return level;
}

// Returns the means over blocks of two by two.
Level pushed(const Level& fine) {
    Level coarse{(fine.num_columns + 1) / 2, (fine.num_rows + 1) / 2, {}, {}};
    const std::size_t num = static_cast<std::size_t>(coarse.num_columns) * coarse.num_rows;
    coarse.heights_m.assign(num, 0.0);
    coarse.weights.assign(num, 0.0);
    for (int row = 0; row < fine.num_rows; ++row)
        for (int column = 0; column < fine.num_columns; ++column) {
            const std::size_t from = fine.index(column, row);
            const std::size_t to = coarse.index(column / 2, row / 2);
            coarse.heights_m[to] += fine.weights[from] * fine.heights_m[from];
            coarse.weights[to] += fine.weights[from];
        }
    for (std::size_t i = 0; i < num; ++i) {
        if (coarse.weights[i] > 0.0) coarse.heights_m[i] /= coarse.weights[i];
        coarse.weights[i] = std::min(1.0, coarse.weights[i]);
    }
    return coarse;
}

// Fills unseen values of the finer level, bilinearly from the four nearest blocks.
void pull(const Level& coarse, Level& fine) {
    for (int row = 0; row < fine.num_rows; ++row)
        for (int column = 0; column < fine.num_columns; ++column) {
            const std::size_t to = fine.index(column, row);
            if (fine.weights[to] > 0.0) continue;
            const int x = column / 2;
            const int y = row / 2;
            const int beside =
                std::clamp(x + (column % 2 == 0 ? -1 : 1), 0, coarse.num_columns - 1);
            const int below = std::clamp(y + (row % 2 == 0 ? -1 : 1), 0, coarse.num_rows - 1);
            fine.heights_m[to] = (9.0 * coarse.heights_m[coarse.index(x, y)] +
                                  3.0 * coarse.heights_m[coarse.index(beside, y)] +
                                  3.0 * coarse.heights_m[coarse.index(x, below)] +
                                  coarse.heights_m[coarse.index(beside, below)]) /
                                 16.0;
        }
}

struct WeightedSums {
    std::vector<double> sums_m;
    std::vector<double> weights;
};

// Goes over every gap of a row or column of `num` nodes, `stride` apart from `first` on.
void add_lower_ends(
    const HeightGrid& grid, std::size_t first, std::size_t stride, int num, WeightedSums& lower) {
    const auto height = [&](int i) { return grid.heights_m[first + i * stride]; };
    for (int begin = 0; begin < num; ++begin) {
        if (height(begin) > kUnseen_m) continue;
        int end = begin;
        while (end < num && !(height(end) > kUnseen_m)) ++end;
        double low_m = begin > 0 ? height(begin - 1) : -kUnseen_m;
        if (end < num) low_m = std::min(low_m, height(end));
        for (int i = begin; i < end && low_m < -kUnseen_m; ++i) {
            const double weight = 1.0 / (end - begin);
            lower.sums_m[first + i * stride] += weight * low_m;
            lower.weights[first + i * stride] += weight;
        }
        begin = end;
    }
}

}  // namespace

HeightGrid gaps_filled(const HeightGrid& grid) {
    const auto num_seen = std::count_if(grid.heights_m.begin(),
                                        grid.heights_m.end(),
                                        [](double height) { return height > kUnseen_m; });
    if (num_seen == 0 || num_seen == static_cast<std::ptrdiff_t>(grid.heights_m.size()))
        return grid;
    std::vector<Level> levels{finest(grid)};
    while (levels.back().num_columns > 1 || levels.back().num_rows > 1)
        levels.push_back(pushed(levels.back()));
    for (std::size_t i = levels.size() - 1; i > 0; --i) pull(levels[i], levels[i - 1]);
    HeightGrid out = grid;
    out.heights_m = std::move(levels.front().heights_m);
    return out;
}

HeightGrid gaps_filled_low(const HeightGrid& grid) {
    const GridShape& shape = grid.shape;
    WeightedSums lower{std::vector<double>(shape.num_nodes()),
                       std::vector<double>(shape.num_nodes())};
    for (int row = 0; row < shape.num_rows; ++row)
        add_lower_ends(grid, shape.index(0, row), 1, shape.num_columns, lower);
    for (int column = 0; column < shape.num_columns; ++column)
        add_lower_ends(grid, column, shape.num_columns, shape.num_rows, lower);
    HeightGrid out = gaps_filled(grid);
    for (std::size_t i = 0; i < lower.weights.size(); ++i)
        if (lower.weights[i] > 0.0) out.heights_m[i] = lower.sums_m[i] / lower.weights[i];
    return out;
}

}  // namespace divemesh::reef
