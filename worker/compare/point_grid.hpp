#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace divemesh::worker {

// Points sorted into cubes, to find those near a place or along a line. 8 bytes a point and 32 a
// cube that holds any. Keeps the points, which may not change while this lives; any number of
// threads may ask. Throws Error{TooLarge} when a side is more than two million cubes long.
class PointGrid {
public:
    PointGrid(const std::vector<Eigen::Vector3f>& points, float cell_m);

    // The nearest point not farther than `reach_m`; of equals the one with the lowest index.
    std::optional<std::uint32_t> nearest(const Eigen::Vector3f& p, float reach_m) const;

    // Calls visit(index) for every point of the cubes that the capsule about from-to touches, and
    // so for some outside of it, each once, always in the same order.
    template <typename Visit>
    void near_segment(const Eigen::Vector3f& from,
                      const Eigen::Vector3f& to,
                      float radius_m,
                      const Visit& visit) const;

    const std::vector<Eigen::Vector3f>& points() const { return points_; }

private:
    using Cell = std::array<int, 3>;
    struct Span {
        std::uint64_t key = kFree;
        std::uint32_t begin = 0;
        std::uint32_t end = 0;
    };
    static constexpr std::uint64_t kFree = ~std::uint64_t{0};

    int index_of(float place_m, int axis) const {
        const float index = std::floor((place_m - low_[axis]) / cell_m_);
        return static_cast<int>(std::clamp(index, -2.0F, static_cast<float>(num_[axis] + 1)));
    }
    bool is_inside(const Cell& cell) const {
        return std::min({cell[0], cell[1], cell[2]}) >= 0 && cell[0] < num_[0] &&
               cell[1] < num_[1] && cell[2] < num_[2];
    }
    const Span* find(const Cell& cell) const;
    template <typename Visit>
    void visit_cell(const Cell& cell, const Visit& visit) const {
        if (const Span* span = find(cell))
            for (std::uint32_t i = span->begin; i < span->end; ++i) visit(order_[i]);
    }
    void sort_points();

    const std::vector<Eigen::Vector3f>& points_;
    float cell_m_;
    Eigen::Vector3f low_ = Eigen::Vector3f::Zero();
    Cell num_{};
    std::vector<std::uint32_t> order_;
    std::vector<Span> table_;  // open addressing
};

template <typename Visit>
void PointGrid::near_segment(const Eigen::Vector3f& from,
                             const Eigen::Vector3f& to,
                             float radius_m,
                             const Visit& visit) const {
    int main = 0;
    (to - from).cwiseAbs().maxCoeff(&main);
    const int side = (main + 1) % 3;
    const int other = (main + 2) % 3;
    const float length = to[main] - from[main];
    const float low = std::min(from[main], to[main]) - radius_m;
    const float high = std::max(from[main], to[main]) + radius_m;
    for (int i = std::max(0, index_of(low, main));
         i <= std::min(num_[main] - 1, index_of(high, main));
         ++i) {
        // What of the line is in this layer and a radius about it.
        const float begin = low_[main] + static_cast<float>(i) * cell_m_ - radius_m;
        const float end = begin + cell_m_ + 2.0F * radius_m;
        const auto along = [&](float place) {
            return length == 0.0F ? 0.0F : std::clamp((place - from[main]) / length, 0.0F, 1.0F);
        };
        const Eigen::Vector3f p = from + along(begin) * (to - from);
        const Eigen::Vector3f q = from + along(end) * (to - from);
        const auto first = [&](int axis) {
            return std::max(0, index_of(std::min(p[axis], q[axis]) - radius_m, axis));
        };
        const auto last = [&](int axis) {
            return std::min(num_[axis] - 1, index_of(std::max(p[axis], q[axis]) + radius_m, axis));
        };
        Cell cell{};
        cell[static_cast<std::size_t>(main)] = i;
        for (int j = first(side); j <= last(side); ++j)
            for (int k = first(other); k <= last(other); ++k) {
                cell[static_cast<std::size_t>(side)] = j;
                cell[static_cast<std::size_t>(other)] = k;
                visit_cell(cell, visit);
            }
    }
}

}  // namespace divemesh::worker
