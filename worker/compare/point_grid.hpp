#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace divemesh::worker {

// Points sorted into cubes, to find those near a place or along a line. Blocks of 8 x 8 x 8 cubes
// that hold any point are found by where they are, and each says which of its cubes do, so that
// what is empty costs next to nothing. 4 bytes a point, 4 a cube and about 150 a block. Keeps the
// points, which may not change while this lives; any number of threads may ask. Throws
// Error{TooLarge} when a side is more than two million cubes long.
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
    // All of them, neighbours near each other.
    const std::vector<std::uint32_t>& in_order() const { return order_; }

private:
    static constexpr int kSide = 8;  // of a block, in cubes

    using Cell = std::array<int, 3>;
    struct Block {
        std::array<std::uint64_t, kSide> cubes{};   // with points: by x, bits by y and z
        std::array<std::uint16_t, kSide> before{};  // of them, those of smaller x
        std::array<std::uint8_t, 3> layers{};       // bits by index along an axis: with points
        std::uint32_t first = 0;                    // in begin_
    };
    struct Slot {
        std::uint64_t key = kFree;
        std::uint32_t block = 0;
    };
    struct Range {
        int first = 0;
        int last = -1;
    };
    static constexpr std::uint64_t kFree = ~std::uint64_t{0};

    int index_of(float place_m, int axis) const {
        const float index = std::floor((place_m - low_[axis]) / cell_m_);
        return static_cast<int>(std::clamp(index, -2.0F, static_cast<float>(num_[axis] + 1)));
    }
    Range range_of(float low_m, float high_m, int axis) const {
        return {std::max(0, index_of(low_m, axis)),
                std::min(num_[static_cast<std::size_t>(axis)] - 1, index_of(high_m, axis))};
    }
    bool is_inside(const Cell& cell) const {
        return std::min({cell[0], cell[1], cell[2]}) >= 0 && cell[0] < num_[0] &&
               cell[1] < num_[1] && cell[2] < num_[2];
    }
    static int in_block(int index) { return index & (kSide - 1); }

    void sort_points();
    void put_into_blocks(const std::vector<std::pair<std::uint64_t, std::uint32_t>>& keyed);
    void make_table(const std::vector<std::uint64_t>& keys);
    const Block* find(const Cell& block) const;
    float squared_distance_to(const Eigen::Vector3f& p, const Cell& first_cube, int side) const;
    template <typename Visit>
    void visit_cell(const Block& block, const Cell& cell, const Visit& visit) const;
    template <typename Offer>
    void visit_nearer(const Eigen::Vector3f& p,
                      const Cell& at,
                      const float& squared_m2,
                      const Offer& offer) const;

    const std::vector<Eigen::Vector3f>& points_;
    float cell_m_;
    float doubt_m_ = 0.0F;  // of a cube's sides, by rounding
    Eigen::Vector3f low_ = Eigen::Vector3f::Zero();
    Cell num_{};
    std::vector<std::uint32_t> order_;  // of the points
    std::vector<std::uint32_t> begin_;  // of each cube's points in it, and its end
    std::vector<Block> blocks_;
    std::vector<Slot> table_;  // open addressing
};

template <typename Visit>
void PointGrid::visit_cell(const Block& block, const Cell& cell, const Visit& visit) const {
    const auto x = static_cast<std::size_t>(in_block(cell[0]));
    const std::uint64_t bit = std::uint64_t{1} << (kSide * in_block(cell[1]) + in_block(cell[2]));
    if ((block.cubes[x] & bit) == 0) return;
    const std::size_t cube = block.first + std::size_t{block.before[x]} +
                             static_cast<std::size_t>(std::popcount(block.cubes[x] & (bit - 1)));
    for (std::uint32_t i = begin_[cube]; i < begin_[cube + 1]; ++i) visit(order_[i]);
}

template <typename Visit>
void PointGrid::near_segment(const Eigen::Vector3f& from,
                             const Eigen::Vector3f& to,
                             float radius_m,
                             const Visit& visit) const {
    if (table_.empty()) return;
    int main = 0;
    (to - from).cwiseAbs().maxCoeff(&main);
    const int side = (main + 1) % 3;
    const int other = (main + 2) % 3;
    const float length = to[main] - from[main];
    const auto along = [&](float place) {
        return length == 0.0F ? 0.0F : std::clamp((place - from[main]) / length, 0.0F, 1.0F);
    };
    // What of the line is in some layers and a radius about it, to either side of it.
    const auto beside = [&](int first_layer, int num_layers, int axis) {
        const float begin = low_[main] + static_cast<float>(first_layer) * cell_m_ - radius_m;
        const float end = begin + static_cast<float>(num_layers) * cell_m_ + 2.0F * radius_m;
        const float p = from[axis] + along(begin) * (to[axis] - from[axis]);
        const float q = from[axis] + along(end) * (to[axis] - from[axis]);
        return range_of(std::min(p, q) - radius_m, std::max(p, q) + radius_m, axis);
    };
    const auto for_blocks = [](const Range& range, const auto& work) {
        for (int block = range.first / kSide; block * kSide <= range.last; ++block) work(block);
    };
    const Range layers = range_of(
        std::min(from[main], to[main]) - radius_m, std::max(from[main], to[main]) + radius_m, main);
    Cell at{};
    Cell cell{};
    const auto of = [](Cell& place, int axis) -> int& {
        return place[static_cast<std::size_t>(axis)];
    };
    const auto visit_layer = [&](int layer) {
        of(cell, main) = layer;
        const Range rows = beside(layer, 1, side);
        const Range columns = beside(layer, 1, other);
        for (of(cell, side) = rows.first; of(cell, side) <= rows.last; ++of(cell, side))
            for_blocks(columns, [&](int block_of_columns) {
                of(at, side) = of(cell, side) / kSide;
                of(at, other) = block_of_columns;
                const Block* block = find(at);
                if (block == nullptr) return;
                const int last = std::min(columns.last, kSide * block_of_columns + kSide - 1);
                for (of(cell, other) = std::max(columns.first, kSide * block_of_columns);
                     of(cell, other) <= last;
                     ++of(cell, other))
                    visit_cell(*block, cell, visit);
            });
    };
    for_blocks(layers, [&](int block_of_layers) {
        of(at, main) = block_of_layers;
        unsigned with_points = 0;
        for_blocks(beside(kSide * block_of_layers, kSide, side), [&](int block_of_rows) {
            of(at, side) = block_of_rows;
            for_blocks(beside(kSide * block_of_layers, kSide, other), [&](int block_of_columns) {
                of(at, other) = block_of_columns;
                if (const Block* block = find(at))
                    with_points |= block->layers[static_cast<std::size_t>(main)];
            });
        });
        for (int i = 0; i < kSide; ++i) {
            const int layer = kSide * block_of_layers + i;
            if ((with_points >> i & 1U) != 0 && layer >= layers.first && layer <= layers.last)
                visit_layer(layer);
        }
    });
}

}  // namespace divemesh::worker
