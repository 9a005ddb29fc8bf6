#include "worker/compare/point_grid.hpp"

#include <limits>

#include "schemas/error.hpp"

namespace divemesh::compare {
namespace {

constexpr int kBitsPerAxis = 16;  // of a region's position
constexpr int kBitsInRegion = 6;
constexpr int kBitsInBlock = 9;

std::uint64_t key_of(const std::array<int, 3>& region) {
    std::uint64_t key = 0;
    for (const int index : region) key = key << kBitsPerAxis | static_cast<std::uint64_t>(index);
    return key;
}

constexpr std::uint64_t lowest_bits(std::uint64_t bits, int num) {
    return bits & ((std::uint64_t{1} << num) - 1);
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
    rounding_m_ = 4.0F * std::numeric_limits<float>::epsilon() *
                  std::max(low_.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        const double num = std::floor(static_cast<double>((high[i] - low_[i]) / cell_m)) + 1.0;
        if (!(num < kRegionSide * kSide * (1 << kBitsPerAxis) - 4))
            throw Error(ErrorCode::TooLarge,
                        "a surface " + std::to_string(high[i] - low_[i]) +
                            " m long is too large for cells of " + std::to_string(cell_m) +
                            " m: choose larger cells");
        num_[axis] = static_cast<int>(num);
    }
    sort_points();
}

void PointGrid::sort_points() {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
        Cell region{};
        std::uint64_t in_region = 0;
        std::uint64_t within = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int index = std::clamp(
                index_of(points_[i][static_cast<Eigen::Index>(axis)], static_cast<int>(axis)),
                0,
                num_[axis] - 1);
            const int block = index / kSide;
            region[axis] = block / kRegionSide;
            in_region = kRegionSide * in_region + static_cast<std::uint64_t>(block % kRegionSide);
            within = kSide * within + static_cast<std::uint64_t>(in_block(index));
        }
        keyed[i] = {(key_of(region) << kBitsInRegion | in_region) << kBitsInBlock | within,
                    static_cast<std::uint32_t>(i)};
    }
    std::sort(keyed.begin(), keyed.end());
    put_into_blocks(keyed);
}

void PointGrid::put_into_blocks(const std::vector<std::pair<std::uint64_t, std::uint32_t>>& keyed) {
    std::vector<Region> regions;
    order_.resize(keyed.size());
    for (std::size_t i = 0; i < keyed.size(); ++i) {
        order_[i] = keyed[i].second;
        if (i > 0 && keyed[i].first == keyed[i - 1].first) continue;
        const std::uint64_t of_block = keyed[i].first >> kBitsInBlock;
        const std::uint64_t of_region = of_block >> kBitsInRegion;
        if (i == 0 || of_block != keyed[i - 1].first >> kBitsInBlock) {
            if (regions.empty() || regions.back().key != of_region)
                regions.push_back({of_region, 0, static_cast<std::uint32_t>(blocks_.size())});
            regions.back().blocks |= std::uint64_t{1} << lowest_bits(of_block, kBitsInRegion);
            blocks_.emplace_back().first = static_cast<std::uint32_t>(begin_.size());
        }
        begin_.push_back(static_cast<std::uint32_t>(i));
        const auto within = static_cast<unsigned>(lowest_bits(keyed[i].first, kBitsInBlock));
        const unsigned x = within / (kSide * kSide);
        Block& block = blocks_.back();
        block.cubes[x] |= std::uint64_t{1} << (within % (kSide * kSide));
        for (std::size_t later = x + 1; later < kSide; ++later) ++block.before[later];
        block.layers[0] |= static_cast<std::uint8_t>(1U << x);
        block.layers[1] |= static_cast<std::uint8_t>(1U << (within / kSide % kSide));
        block.layers[2] |= static_cast<std::uint8_t>(1U << (within % kSide));
    }
    begin_.push_back(static_cast<std::uint32_t>(keyed.size()));
    make_table(regions);
}

void PointGrid::make_table(const std::vector<Region>& regions) {
    std::size_t capacity = 16;
    while (capacity < 2 * regions.size()) capacity *= 2;
    table_.resize(capacity);
    for (const Region& region : regions) {
        std::size_t slot = scatter(region.key) & (capacity - 1);
        while (table_[slot].key != kFree) slot = (slot + 1) & (capacity - 1);
        table_[slot] = region;
    }
}

const PointGrid::Region* PointGrid::find_region(const Cell& region) const {
    const std::uint64_t key = key_of(region);
    for (std::size_t slot = scatter(key) & (table_.size() - 1);;
         slot = (slot + 1) & (table_.size() - 1)) {
        if (table_[slot].key == key) return &table_[slot];
        if (table_[slot].key == kFree) return nullptr;
    }
}

const PointGrid::Block* PointGrid::find(const Cell& block) const {
    const Region* region =
        find_region({block[0] / kRegionSide, block[1] / kRegionSide, block[2] / kRegionSide});
    if (region == nullptr) return nullptr;
    int bit = 0;
    for (const int index : block) bit = kRegionSide * bit + index % kRegionSide;
    if ((region->blocks >> bit & 1U) == 0) return nullptr;
    return &blocks_[region->first +
                    static_cast<std::size_t>(std::popcount(lowest_bits(region->blocks, bit)))];
}

// Returns the squared distance of a point along an axis from each of some slabs of `num_cubes`
// cubes; a lower bound.
template <int num>
std::array<float, num> PointGrid::squared_off(float place_m,
                                              int axis,
                                              int first_cube,
                                              int num_cubes) const {
    std::array<float, num> squares{};
    for (int i = 0; i < num; ++i) {
        const int first = first_cube + i * num_cubes;
        const float low = low_[axis] + static_cast<float>(first) * cell_m_ - rounding_m_;
        const float high =
            low_[axis] + static_cast<float>(first + num_cubes) * cell_m_ + rounding_m_;
        const float off = std::max({0.0F, low - place_m, place_m - high});
        squares[static_cast<std::size_t>(i)] = off * off;
    }
    return squares;
}

// Both offer the points of cubes that are not farther than `squared_m2`, which may decrease
// meanwhile: of the block with its first cube at `corner`, and of the region at `at`.
template <typename Offer>
void PointGrid::visit_nearer(const Eigen::Vector3f& p,
                             const Cell& corner,
                             const Block& block,
                             const float& squared_m2,
                             const Offer& offer) const {
    const auto off_x = squared_off<kSide>(p.x(), 0, corner[0], 1);
    const auto off_y = squared_off<kSide>(p.y(), 1, corner[1], 1);
    const auto off_z = squared_off<kSide>(p.z(), 2, corner[2], 1);
    for (unsigned x = 0; x < kSide; ++x) {
        if (off_x[x] > squared_m2) continue;
        for (std::uint64_t rest = block.cubes[x]; rest != 0; rest &= rest - 1) {
            const auto bit = static_cast<unsigned>(std::countr_zero(rest));
            const unsigned y = bit / kSide;
            const unsigned z = bit % kSide;
            if (off_x[x] + off_y[y] + off_z[z] > squared_m2) continue;
            visit_cell(block,
                       {corner[0] + static_cast<int>(x),
                        corner[1] + static_cast<int>(y),
                        corner[2] + static_cast<int>(z)},
                       offer);
        }
    }
}

template <typename Offer>
void PointGrid::visit_nearer(const Eigen::Vector3f& p,
                             const Cell& at,
                             const float& squared_m2,
                             const Offer& offer) const {
    const Region* region = find_region(at);
    if (region == nullptr) return;
    constexpr int kCubes = kRegionSide * kSide;
    const Cell corner{kCubes * at[0], kCubes * at[1], kCubes * at[2]};
    const auto off_x = squared_off<kRegionSide>(p.x(), 0, corner[0], kSide);
    const auto off_y = squared_off<kRegionSide>(p.y(), 1, corner[1], kSide);
    const auto off_z = squared_off<kRegionSide>(p.z(), 2, corner[2], kSide);
    std::size_t block = region->first;
    for (std::uint64_t rest = region->blocks; rest != 0; rest &= rest - 1, ++block) {
        const auto bit = static_cast<unsigned>(std::countr_zero(rest));
        const unsigned x = bit / (kRegionSide * kRegionSide);
        const unsigned y = bit / kRegionSide % kRegionSide;
        const unsigned z = bit % kRegionSide;
        if (off_x[x] + off_y[y] + off_z[z] > squared_m2) continue;
        visit_nearer(p,
                     {corner[0] + kSide * static_cast<int>(x),
                      corner[1] + kSide * static_cast<int>(y),
                      corner[2] + kSide * static_cast<int>(z)},
                     blocks_[block],
                     squared_m2,
                     offer);
    }
}

std::optional<std::uint32_t> PointGrid::nearest(const Eigen::Vector3f& p,
                                                float reach_m,
                                                std::optional<std::uint32_t> hint) const {
    if (table_.empty()) return std::nullopt;
    std::optional<std::uint32_t> best;
    float best_squared = reach_m * reach_m;
    const auto offer = [&](std::uint32_t i) {
        const float squared = (points_[i] - p).squaredNorm();
        if (squared > best_squared || (squared == best_squared && best && *best < i)) return;
        best_squared = squared;
        best = i;
    };
    if (hint) offer(*hint);
    const auto for_places = [&](float within_m, int side, const auto& work) {
        std::array<Range, 3> ranges;
        for (int axis = 0; axis < 3; ++axis) {
            const float far_m = within_m + rounding_m_;
            const Range cubes = range_of(p[axis] - far_m, p[axis] + far_m, axis);
            if (cubes.last < cubes.first) return;
            ranges[static_cast<std::size_t>(axis)] = {cubes.first / side, cubes.last / side};
        }
        for (int x = ranges[0].first; x <= ranges[0].last; ++x)
            for (int y = ranges[1].first; y <= ranges[1].last; ++y)
                for (int z = ranges[2].first; z <= ranges[2].last; ++z) work({x, y, z});
    };
    for_places(cell_m_, 1, [&](const Cell& cell) {
        if (const Block* block = find({cell[0] / kSide, cell[1] / kSide, cell[2] / kSide}))
            visit_cell(*block, cell, offer);
    });
    if (std::sqrt(best_squared) < cell_m_) return best;  // all other points are farther
    for_places(std::sqrt(best_squared), kRegionSide * kSide, [&](const Cell& region) {
        visit_nearer(p, region, best_squared, offer);
    });
    return best;
}

}  // namespace divemesh::compare
