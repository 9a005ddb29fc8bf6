#include "worker/compare/point_grid.hpp"

#include <limits>

#include "schemas/error.hpp"

namespace divemesh::worker {
namespace {

constexpr int kBitsPerAxis = 18;  // of a block's place
constexpr int kBitsInBlock = 9;

std::uint64_t key_of(const std::array<int, 3>& block) {
    std::uint64_t key = 0;
    for (const int index : block) key = key << kBitsPerAxis | static_cast<std::uint64_t>(index);
    return key;
}

std::uint64_t scatter(std::uint64_t key) {  // Fibonacci hashing (Knuth 6.4)
    key *= 0x9e3779b97f4a7c15ULL;
    return key ^ (key >> 32);
}

// Places that are `ring` from the middle along some axis and not farther along any.
template <typename Work>
void for_each_on_ring(const std::array<int, 3>& middle, int ring, const Work& work) {
    for (int x = -ring; x <= ring; ++x)
        for (int y = -ring; y <= ring; ++y) {
            const bool face = std::max(std::abs(x), std::abs(y)) == ring;
            for (int z = -ring; z <= ring; z += face || ring == 0 ? 1 : 2 * ring)
                work({middle[0] + x, middle[1] + y, middle[2] + z});
        }
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
    doubt_m_ = 4.0F * std::numeric_limits<float>::epsilon() *
               std::max(low_.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        const double num = std::floor(static_cast<double>((high[i] - low_[i]) / cell_m)) + 1.0;
        if (!(num < kSide * (1 << kBitsPerAxis) - 4))
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
        Cell block{};
        std::uint64_t within = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int index = std::clamp(
                index_of(points_[i][static_cast<Eigen::Index>(axis)], static_cast<int>(axis)),
                0,
                num_[axis] - 1);
            block[axis] = index / kSide;
            within = kSide * within + static_cast<std::uint64_t>(in_block(index));
        }
        keyed[i] = {key_of(block) << kBitsInBlock | within, static_cast<std::uint32_t>(i)};
    }
    std::sort(keyed.begin(), keyed.end());
    put_into_blocks(keyed);
}

void PointGrid::put_into_blocks(const std::vector<std::pair<std::uint64_t, std::uint32_t>>& keyed) {
    constexpr std::uint64_t kWithin = (std::uint64_t{1} << kBitsInBlock) - 1;
    std::vector<std::uint64_t> keys;
    order_.resize(keyed.size());
    for (std::size_t i = 0; i < keyed.size(); ++i) {
        order_[i] = keyed[i].second;
        if (i > 0 && keyed[i].first == keyed[i - 1].first) continue;
        const std::uint64_t key = keyed[i].first >> kBitsInBlock;
        if (keys.empty() || keys.back() != key) {
            keys.push_back(key);
            blocks_.emplace_back().first = static_cast<std::uint32_t>(begin_.size());
        }
        begin_.push_back(static_cast<std::uint32_t>(i));
        const auto within = static_cast<unsigned>(keyed[i].first & kWithin);
        const unsigned x = within / (kSide * kSide);
        Block& block = blocks_.back();
        block.cubes[x] |= std::uint64_t{1} << (within % (kSide * kSide));
        for (std::size_t later = x + 1; later < kSide; ++later) ++block.before[later];
        block.layers[0] |= static_cast<std::uint8_t>(1U << x);
        block.layers[1] |= static_cast<std::uint8_t>(1U << (within / kSide % kSide));
        block.layers[2] |= static_cast<std::uint8_t>(1U << (within % kSide));
    }
    begin_.push_back(static_cast<std::uint32_t>(keyed.size()));
    make_table(keys);
}

void PointGrid::make_table(const std::vector<std::uint64_t>& keys) {
    std::size_t capacity = 16;
    while (capacity < 2 * keys.size()) capacity *= 2;
    table_.resize(capacity);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        std::size_t slot = scatter(keys[i]) & (capacity - 1);
        while (table_[slot].key != kFree) slot = (slot + 1) & (capacity - 1);
        table_[slot] = {keys[i], static_cast<std::uint32_t>(i)};
    }
}

const PointGrid::Block* PointGrid::find(const Cell& block) const {
    const std::uint64_t key = key_of(block);
    for (std::size_t slot = scatter(key) & (table_.size() - 1);;
         slot = (slot + 1) & (table_.size() - 1)) {
        if (table_[slot].key == key) return &blocks_[table_[slot].block];
        if (table_[slot].key == kFree) return nullptr;
    }
}

// Of a cube of `side` cubes; not more than it is.
float PointGrid::squared_distance_to(const Eigen::Vector3f& p,
                                     const Cell& first_cube,
                                     int side) const {
    float sum = 0.0F;
    for (int axis = 0; axis < 3; ++axis) {
        const int first = first_cube[static_cast<std::size_t>(axis)];
        const float low = low_[axis] + static_cast<float>(first) * cell_m_ - doubt_m_;
        const float high = low_[axis] + static_cast<float>(first + side) * cell_m_ + doubt_m_;
        const float off = std::max({0.0F, low - p[axis], p[axis] - high});
        sum += off * off;
    }
    return sum;
}

// Offers the points of a block's cubes that are nearer than `squared_m2` says while this goes on.
template <typename Offer>
void PointGrid::visit_nearer(const Eigen::Vector3f& p,
                             const Cell& at,
                             const float& squared_m2,
                             const Offer& offer) const {
    const Cell corner{kSide * at[0], kSide * at[1], kSide * at[2]};
    if (squared_distance_to(p, corner, kSide) > squared_m2) return;
    const Block* block = find(at);
    if (block == nullptr) return;
    for (int x = 0; x < kSide; ++x)
        for (std::uint64_t rest = block->cubes[static_cast<std::size_t>(x)]; rest != 0;
             rest &= rest - 1) {
            const int bit = std::countr_zero(rest);
            const Cell cell{corner[0] + x, corner[1] + bit / kSide, corner[2] + in_block(bit)};
            if (squared_distance_to(p, cell, 1) <= squared_m2) visit_cell(*block, cell, offer);
        }
}

std::optional<std::uint32_t> PointGrid::nearest(const Eigen::Vector3f& p, float reach_m) const {
    if (table_.empty()) return std::nullopt;
    std::optional<std::uint32_t> best;
    float best_squared = reach_m * reach_m;
    const auto offer = [&](std::uint32_t i) {
        const float squared = (points_[i] - p).squaredNorm();
        if (squared > best_squared || (squared == best_squared && best && *best < i)) return;
        best_squared = squared;
        best = i;
    };
    const Cell middle{index_of(p.x(), 0), index_of(p.y(), 1), index_of(p.z(), 2)};
    for (const int ring : {0, 1})
        for_each_on_ring(middle, ring, [&](const Cell& cell) {
            if (!is_inside(cell)) return;
            if (const Block* block = find({cell[0] / kSide, cell[1] / kSide, cell[2] / kSide}))
                visit_cell(*block, cell, offer);
        });
    const auto farther_than_best = [&](float distance_m) {
        return distance_m > 0.0F && distance_m * distance_m > best_squared;
    };
    if (farther_than_best(cell_m_ - doubt_m_)) return best;  // than all others are
    const float side_m = kSide * cell_m_;
    const int most = static_cast<int>(std::ceil(reach_m / side_m)) + 1;
    const auto block_of = [](int index) { return (index + kSide) / kSide - 1; };  // -2 is the least
    const Cell block{block_of(middle[0]), block_of(middle[1]), block_of(middle[2])};
    for (int ring = 0; ring <= most; ++ring) {
        if (farther_than_best(static_cast<float>(ring - 1) * side_m - doubt_m_)) break;
        for_each_on_ring(block, ring, [&](const Cell& at) {
            if (is_inside({kSide * at[0], kSide * at[1], kSide * at[2]}))
                visit_nearer(p, at, best_squared, offer);
        });
    }
    return best;
}

}  // namespace divemesh::worker
