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

namespace divemesh::compare {

// Points sorted into cubes, to find those near a point or along a line. 8 x 8 x 8 cubes are a block
// and 4 x 4 x 4 blocks a region. Regions are found by their position, and each level stores which
// of the next contain points, so empty space costs almost no time. It needs 4 bytes a point, 4 a
// cube and about 100 a block. It refers to the points, which must not change during its lifetime;
// any number of threads may query it. Throws Error{TooLarge} if a side is more than two million
// cubes long.
class PointGrid {
public:
    PointGrid(const std::vector<Eigen::Vector3f>& points, float cell_m);

    // Returns the nearest point within `reach_m`, the one with the lowest index among equals;
    // nullopt if there is none. A `hint`, a point that is probably near, limits the search to its
    // distance.
    std::optional<std::uint32_t> nearest(const Eigen::Vector3f& p,
                                         float reach_m,
                                         std::optional<std::uint32_t> hint = {}) const;

    // Calls visit(index) for every point of the cubes that the capsule around from-to touches, so
    // also for some points outside it: each once, always in the same order.
    template <typename Visit>
    void near_segment(const Eigen::Vector3f& from,
                      const Eigen::Vector3f& to,
                      float radius_m,
                      const Visit& visit) const;

    const std::vector<Eigen::Vector3f>& points() const { return points_; }
    // Returns all indices, with neighbours near each other.
    const std::vector<std::uint32_t>& in_order() const { return order_; }

private:
    static constexpr int kSide = 8;        // of a block, in cubes
    static constexpr int kRegionSide = 4;  // in blocks

    using Cell = std::array<int, 3>;
    struct Block {
        std::array<std::uint64_t, kSide> cubes{};   // with points: by x, bits by y and z
        std::array<std::uint16_t, kSide> before{};  // number of these with smaller x
        std::array<std::uint8_t, 3> layers{};       // with points: bits by index along an axis
        std::uint32_t first = 0;                    // in begin_
    };
    struct Region {
        std::uint64_t key = kFree;
        std::uint64_t blocks = 0;  // with points: bits by x, y and z
        std::uint32_t first = 0;   // in blocks_
    };
    struct Range {
        int first = 0;
        int last = -1;
    };
    struct Capsule;
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
    void make_table(const std::vector<Region>& regions);
    const Region* find_region(const Cell& region) const;
    const Block* find(const Cell& block) const;
    template <int num>
    std::array<float, num> squared_off(float place_m,
                                       int axis,
                                       int first_cube,
                                       int num_cubes) const;
    template <typename Visit>
    void visit_layer(const Capsule& capsule, int layer, const Visit& visit) const;
    template <typename Visit>
    void visit_cell(const Block& block, const Cell& cell, const Visit& visit) const;
    template <typename Offer>
    void visit_nearer(const Eigen::Vector3f& p,
                      const Cell& corner,
                      const Block& block,
                      const float& squared_m2,
                      const Offer& offer) const;
    template <typename Offer>
    void visit_nearer(const Eigen::Vector3f& p,
                      const Cell& at,
                      const float& squared_m2,
                      const Offer& offer) const;

    const std::vector<Eigen::Vector3f>& points_;
    float cell_m_;
    float rounding_m_ = 0.0F;  // rounding error of a cube's sides
    Eigen::Vector3f low_ = Eigen::Vector3f::Zero();
    Cell num_{};
    std::vector<std::uint32_t> order_;  // of the points
    std::vector<std::uint32_t> begin_;  // where each cube's points begin in it, and its end
    std::vector<Block> blocks_;
    std::vector<Region> table_;  // open addressing
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

// Layers are perpendicular to the axis along which the line is longest; rows and columns lie along
// the next two axes.
struct PointGrid::Capsule {
    const PointGrid& grid;
    Eigen::Vector3f from;
    Eigen::Vector3f to;
    float radius_m;
    int main = 0;
    int side = 1;
    int other = 2;

    Capsule(const PointGrid& cubes,
            const Eigen::Vector3f& begin,
            const Eigen::Vector3f& end,
            float radius)
        : grid(cubes), from(begin), to(end), radius_m(radius) {
        (to - from).cwiseAbs().maxCoeff(&main);
        side = (main + 1) % 3;
        other = (main + 2) % 3;
    }

    Range layers() const {
        return grid.range_of(std::min(from[main], to[main]) - radius_m,
                             std::max(from[main], to[main]) + radius_m,
                             main);
    }
    // Returns the range along an axis that the line covers within some layers, extended by the
    // radius.
    Range beside(int first_layer, int num_layers, int axis) const {
        const float begin =
            grid.low_[main] + static_cast<float>(first_layer) * grid.cell_m_ - radius_m;
        const float end = begin + static_cast<float>(num_layers) * grid.cell_m_ + 2.0F * radius_m;
        const float p = from[axis] + share_at(begin) * (to[axis] - from[axis]);
        const float q = from[axis] + share_at(end) * (to[axis] - from[axis]);
        return grid.range_of(std::min(p, q) - radius_m, std::max(p, q) + radius_m, axis);
    }
    Cell place(int layer, int row, int column) const {
        Cell cell{};
        cell[static_cast<std::size_t>(main)] = layer;
        cell[static_cast<std::size_t>(side)] = row;
        cell[static_cast<std::size_t>(other)] = column;
        return cell;
    }
    // Returns a bit for each of a block's layers that contain points.
    unsigned layers_with_points(int block) const {
        const Range rows = beside(kSide * block, kSide, side);
        const Range columns = beside(kSide * block, kSide, other);
        unsigned bits = 0;
        for (int row = rows.first / kSide; row * kSide <= rows.last; ++row)
            for (int column = columns.first / kSide; column * kSide <= columns.last; ++column)
                if (const Block* found = grid.find(place(block, row, column)))
                    bits |= found->layers[static_cast<std::size_t>(main)];
        return bits;
    }

private:
    float share_at(float place_m) const {
        const float length = to[main] - from[main];
        return length == 0.0F ? 0.0F : std::clamp((place_m - from[main]) / length, 0.0F, 1.0F);
    }
};

template <typename Visit>
void PointGrid::visit_layer(const Capsule& capsule, int layer, const Visit& visit) const {
    const Range rows = capsule.beside(layer, 1, capsule.side);
    const Range columns = capsule.beside(layer, 1, capsule.other);
    for (int row = rows.first; row <= rows.last; ++row)
        for (int of_columns = columns.first / kSide; of_columns * kSide <= columns.last;
             ++of_columns) {
            const Block* block = find(capsule.place(layer / kSide, row / kSide, of_columns));
            if (block == nullptr) continue;
            const int last = std::min(columns.last, kSide * of_columns + kSide - 1);
            for (int column = std::max(columns.first, kSide * of_columns); column <= last; ++column)
                visit_cell(*block, capsule.place(layer, row, column), visit);
        }
}

template <typename Visit>
void PointGrid::near_segment(const Eigen::Vector3f& from,
                             const Eigen::Vector3f& to,
                             float radius_m,
                             const Visit& visit) const {
    if (table_.empty()) return;
    const Capsule capsule(*this, from, to, radius_m);
    const Range layers = capsule.layers();
    for (int block = layers.first / kSide; block * kSide <= layers.last; ++block) {
        const unsigned with_points = capsule.layers_with_points(block);
        for (int i = 0; i < kSide; ++i) {
            const int layer = kSide * block + i;
            if ((with_points >> i & 1U) != 0 && layer >= layers.first && layer <= layers.last)
                visit_layer(capsule, layer, visit);
        }
    }
}

}  // namespace divemesh::compare
