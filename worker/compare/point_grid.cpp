#include "worker/compare/point_grid.hpp"

#include <limits>
#include <utility>

#include "schemas/error.hpp"

namespace divemesh::worker {
namespace {

constexpr int kBitsPerAxis = 21;

std::uint64_t key_of(const std::array<int, 3>& cell) {
    std::uint64_t key = 0;
    for (const int index : cell) key = key << kBitsPerAxis | static_cast<std::uint64_t>(index);
    return key;
}

std::uint64_t scatter(std::uint64_t key) {  // Fibonacci hashing (Knuth 6.4)
    key *= 0x9e3779b97f4a7c15ULL;
    return key ^ (key >> 32);
}

}  // namespace

PointGrid::PointGrid(const std::vector<Eigen::Vector3f>& points, float cell_m)
    : points_(points), cell_m_(cell_m) {
    if (points.empty()) return;
    Eigen::Vector3f high = points.front();
    low_ = high;
    for (const Eigen::Vector3f& p : points) {
        low_ = low_.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        const double num = std::floor(static_cast<double>((high[i] - low_[i]) / cell_m)) + 1.0;
        if (!(num < (1 << kBitsPerAxis) - 4))
            throw Error(ErrorCode::TooLarge,
                        "a surface " + std::to_string(high[i] - low_[i]) +
                            " m long is too large for cells of " + std::to_string(cell_m) + " m");
        num_[axis] = static_cast<int>(num);
    }
    sort_points();
}

void PointGrid::sort_points() {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
        Cell cell{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            cell[axis] = std::clamp(
                index_of(points_[i][static_cast<Eigen::Index>(axis)], static_cast<int>(axis)),
                0,
                num_[axis] - 1);
        keyed[i] = {key_of(cell), static_cast<std::uint32_t>(i)};
    }
    std::sort(keyed.begin(), keyed.end());
    std::size_t num_cells = 0;
    for (std::size_t i = 0; i < keyed.size(); ++i)
        num_cells += i == 0 || keyed[i].first != keyed[i - 1].first;
    std::size_t capacity = 16;
    while (capacity < 2 * num_cells) capacity *= 2;
    table_.resize(capacity);
    order_.resize(keyed.size());
    for (std::size_t begin = 0, end = 0; begin < keyed.size(); begin = end) {
        for (end = begin; end < keyed.size() && keyed[end].first == keyed[begin].first; ++end)
            order_[end] = keyed[end].second;
        std::size_t slot = scatter(keyed[begin].first) & (capacity - 1);
        while (table_[slot].key != kFree) slot = (slot + 1) & (capacity - 1);
        table_[slot] = {
            keyed[begin].first, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end)};
    }
}

const PointGrid::Span* PointGrid::find(const Cell& cell) const {
    if (table_.empty()) return nullptr;
    const std::uint64_t key = key_of(cell);
    for (std::size_t slot = scatter(key) & (table_.size() - 1);;
         slot = (slot + 1) & (table_.size() - 1)) {
        if (table_[slot].key == key) return &table_[slot];
        if (table_[slot].key == kFree) return nullptr;
    }
}

std::optional<std::uint32_t> PointGrid::nearest(const Eigen::Vector3f& p, float reach_m) const {
    Cell middle{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        middle[axis] = index_of(p[static_cast<Eigen::Index>(axis)], static_cast<int>(axis));
    std::optional<std::uint32_t> best;
    float best_squared = reach_m * reach_m;
    const auto offer = [&](std::uint32_t i) {
        const float squared = (points_[i] - p).squaredNorm();
        if (squared > best_squared || (squared == best_squared && best && *best < i)) return;
        best_squared = squared;
        best = i;
    };
    const int most = static_cast<int>(std::ceil(reach_m / cell_m_)) + 2;
    for (int ring = 0; ring <= most; ++ring) {
        const float nearer = static_cast<float>(ring - 1) * cell_m_;  // than all of this ring
        if (ring > 0 && nearer * nearer > best_squared) break;
        for (int x = -ring; x <= ring; ++x)
            for (int y = -ring; y <= ring; ++y) {
                const bool face = std::max(std::abs(x), std::abs(y)) == ring;
                for (int z = -ring; z <= ring; z += face || ring == 0 ? 1 : 2 * ring) {
                    const Cell cell{middle[0] + x, middle[1] + y, middle[2] + z};
                    if (is_inside(cell)) visit_cell(cell, offer);
                }
            }
    }
    return best;
}

}  // namespace divemesh::worker
