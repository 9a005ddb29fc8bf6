#include "worker/io/thin_points.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

namespace divemesh::io {
namespace {

constexpr int kMaxLevel = 21;  // 2^21 cells a side: three coordinates fit into 64 bits

// The Morton code of a point's finest cell, and its index.
using Cell = std::pair<std::uint64_t, std::size_t>;

// Returns the low 21 bits of a value with two zeros after each.
std::uint64_t spread(std::uint64_t value) {
    value = (value | value << 32) & 0x001f00000000ffff;
    value = (value | value << 16) & 0x001f0000ff0000ff;
    value = (value | value << 8) & 0x100f00f00f00f00f;
    value = (value | value << 4) & 0x10c30c30c30c30c3;
    return (value | value << 2) & 0x1249249249249249;
}

std::vector<Cell> sorted_cells(const std::vector<Eigen::Vector3f>& points) {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::max());
    Eigen::Vector3d high = -low;
    for (const Eigen::Vector3f& point : points) {
        low = low.cwiseMin(point.cast<double>());
        high = high.cwiseMax(point.cast<double>());
    }
    constexpr double kCells = 1 << kMaxLevel;
    const double side_m = std::max((high - low).maxCoeff(), std::numeric_limits<double>::min());
    std::vector<Cell> cells;
    cells.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d place = (points[i].cast<double>() - low) / side_m * kCells;
        std::uint64_t code = 0;
        for (int axis = 0; axis < 3; ++axis)
            code |= spread(static_cast<std::uint64_t>(std::min(place[axis], kCells - 1.0))) << axis;
        cells.emplace_back(code, i);
    }
    std::sort(cells.begin(), cells.end());
    return cells;
}

// Returns the coarsest level at which two codes are in different cells; 0: both are equal.
int parting_level(std::uint64_t a, std::uint64_t b) {
    const auto num_bits = static_cast<int>(std::bit_width(a ^ b));
    return num_bits == 0 ? 0 : kMaxLevel - (num_bits - 1) / 3;
}

// Returns the coarsest level that has more occupied cells than `max_cells`; the finest one if none
// has.
int level_beyond(const std::vector<Cell>& cells, std::size_t max_cells) {
    std::array<std::size_t, kMaxLevel + 1> num_parted{};
    for (std::size_t i = 1; i < cells.size(); ++i)
        ++num_parted[static_cast<std::size_t>(parting_level(cells[i - 1].first, cells[i].first))];
    std::size_t num_cells = 1;
    for (int level = 1; level < kMaxLevel; ++level) {
        num_cells += num_parted[static_cast<std::size_t>(level)];
        if (num_cells > max_cells) return level;
    }
    return kMaxLevel;
}

}  // namespace

std::vector<std::size_t> thin_points(const std::vector<Eigen::Vector3f>& points,
                                     std::size_t max_points) {
    std::vector<std::size_t> indices(points.size());
    std::iota(indices.begin(), indices.end(), std::size_t{0});
    if (points.size() <= max_points) return indices;
    const std::vector<Cell> cells = sorted_cells(points);
    const int level = level_beyond(cells, max_points);
    std::vector<std::size_t> firsts;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const int parted = i == 0 ? 1 : parting_level(cells[i - 1].first, cells[i].first);
        if (parted > 0 && parted <= level) firsts.push_back(cells[i].second);
    }
    indices.resize(std::min(max_points, firsts.size()));
    for (std::size_t i = 0; i < indices.size(); ++i)
        indices[i] = firsts[i * firsts.size() / indices.size()];
    std::sort(indices.begin(), indices.end());
    return indices;
}

}  // namespace divemesh::io
