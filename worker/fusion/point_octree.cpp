#include "worker/fusion/point_octree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "worker/fusion/packed_values.hpp"

namespace divemesh::fusion {
namespace {

// Above the bricks: all below a node of that level is visited between two trims.
constexpr int kLevelsPerTrim = 4;

// Moves one of three means toward a new value by its share; values are in steps and not negative.
std::uint32_t moved(std::uint32_t means, int i, float value, float share) {
    const auto before = static_cast<float>(unpack(means, i));
    const float shifted = before + share * (value - before) + 0.5F;
    const auto after = static_cast<std::int32_t>(shifted);
    return packed(std::clamp(after, 0, PackedTriple::largest(i)), i);
}

}  // namespace

PointOctree::PointOctree(double leaf_m, SpillSettings spill)
    : leaf_m_(leaf_m),
      bricks_(std::move(spill), [this](std::uint32_t owner, BrickStore::Handle brick) {
          nodes_[owner / 8][owner % 8] = brick + 1;
      }) {
    nodes_.add(Node{});  // root; as a child, 0 means no child
}

bool PointOctree::inside(const Eigen::Vector3i& cell) {
    constexpr int kLimit = 1 << (kLeafLevels - 1);
    return (cell.array() >= -kLimit).all() && (cell.array() < kLimit).all();
}

bool PointOctree::insert(const PointObservation& observation) {
    const Eigen::Vector3d scaled = observation.p_world / leaf_m_;
    if (!(scaled.array().abs() < 1e9).all()) return false;
    Eigen::Vector3i cell = scaled.cast<int>();
    for (int axis = 0; axis < 3; ++axis) cell[axis] -= scaled[axis] < cell[axis] ? 1 : 0;
    if (!inside(cell)) return false;
    PointLeaf& leaf = leaf_at(cell);
    const bool is_new = leaf.weight == 0;
    const float weight = unpack_weight(leaf.weight) + observation.weight;
    const float share = is_new ? 1.0F : observation.weight / weight;
    const float color_share = std::max(share, kMinColorShare);
    const Eigen::Vector3f place = (scaled - cell.cast<double>()).cast<float>();
    PointLeaf mean = leaf;
    mean.weight = pack_weight(weight);
    mean.place = mean.normal = mean.color = 0;
    for (int i = 0; i < 3; ++i) {
        const auto steps = static_cast<float>(PackedTriple::largest(i));
        const auto grey =
            static_cast<float>(observation.color[i] * PackedTriple::steps_per_grey(i));
        mean.place |= moved(leaf.place, i, steps * place[i], share);
        mean.normal |= moved(leaf.normal, i, 0.5F * steps * (observation.normal[i] + 1.0F), share);
        mean.color |= moved(leaf.color, i, grey + 1.0F, color_share);
    }
    if ((is_new || leaf.last_view != observation.view) && leaf.num_views < 255) ++mean.num_views;
    mean.last_view = observation.view;
    leaf = mean;
    return true;
}

bool PointOctree::restore(const Eigen::Vector3i& cell, const PointLeaf& leaf) {
    if (!inside(cell)) return false;
    leaf_at(cell) = leaf;
    return true;
}

// Bricks are counted from the cube's corner, so that bit kLevels - 1 - level of each coordinate
// selects the child at that level. The descent starts at the node where the paths of this brick and
// the last one part.
BrickStore::Handle PointOctree::brick_at(const Eigen::Vector3i& at) {
    const auto parted = static_cast<unsigned>((at.x() ^ last_at_.x()) | (at.y() ^ last_at_.y()) |
                                              (at.z() ^ last_at_.z()));
    // The first level whose node may differ from the last brick's.
    int level =
        std::min(kLevels - 1, std::max(0, kLevels - static_cast<int>(std::bit_width(parted))));
    while (level > 0 && path_[level] == 0) --level;
    last_at_ = at;
    std::uint32_t node = path_[level];
    for (;; ++level) {
        path_[level] = node;
        const int shift = kLevels - 1 - level;
        const int child = ((at.x() >> shift) & 1) | (((at.y() >> shift) & 1) << 1) |
                          (((at.z() >> shift) & 1) << 2);
        std::uint32_t& next = nodes_[node][child];
        if (level == kLevels - 1) {
            if (next == 0) next = bricks_.make(8 * node + child) + 1;
            return next - 1;
        }
        if (next == 0) next = nodes_.add(Node{});
        node = next;
    }
}

PointLeaf& PointOctree::leaf_at(const Eigen::Vector3i& cell) {
    const Eigen::Vector3i at = cell.array() + (1 << (kLeafLevels - 1));
    return bricks_.leaf(brick_at({at.x() >> 3, at.y() >> 3, at.z() >> 3}), index_in_block(at));
}

const PointLeaf* PointOctree::find(const Eigen::Vector3i& cell) const {
    if (!inside(cell)) return nullptr;
    const Eigen::Vector3i at = cell.array() + (1 << (kLeafLevels - 1));
    std::uint32_t node = 0;
    for (int shift = kLeafLevels - 1; shift >= 3; --shift) {
        const int child = ((at.x() >> shift) & 1) | (((at.y() >> shift) & 1) << 1) |
                          (((at.z() >> shift) & 1) << 2);
        node = nodes_[node][child];
        if (node == 0) return nullptr;
    }
    return bricks_.find(node - 1, index_in_block(at));
}

void PointOctree::for_each(const Visit& visit) const {
    visit_below(0, 0, Eigen::Vector3i::Constant(-(1 << (kLevels - 1))), visit);
}

void PointOctree::visit_below(std::uint32_t node,
                              int level,
                              const Eigen::Vector3i& first_brick,
                              const Visit& visit) const {
    if (level == kLevels - kLevelsPerTrim) trim();
    const int half = 1 << (kLevels - 1 - level);
    for (int child = 0; child < 8; ++child) {
        const std::uint32_t next = nodes_[node][child];
        if (next == 0) continue;
        const Eigen::Vector3i brick =
            first_brick + half * Eigen::Vector3i(child & 1, (child >> 1) & 1, (child >> 2) & 1);
        if (level == kLevels - 1)
            visit_brick(next - 1, brick, visit);
        else
            visit_below(next, level + 1, brick, visit);
    }
}

void PointOctree::visit_brick(BrickStore::Handle brick,
                              const Eigen::Vector3i& coordinate,
                              const Visit& visit) const {
    bricks_.for_each(brick, [&](int place, const PointLeaf& leaf) {
        visit(kBlockEdge * coordinate + Eigen::Vector3i(place & 7, (place >> 3) & 7, place >> 6),
              leaf);
    });
}

Eigen::Vector3d PointOctree::position(const Eigen::Vector3i& cell, const PointLeaf& leaf) const {
    Eigen::Vector3d position = cell.cast<double>();
    for (int i = 0; i < 3; ++i)
        position[i] += static_cast<double>(unpack(leaf.place, i)) / PackedTriple::largest(i);
    return leaf_m_ * position;
}

std::int64_t PointOctree::size_bytes() const {
    return bricks_.size_bytes() + static_cast<std::int64_t>(nodes_.memory_bytes());
}

std::int64_t PointOctree::memory_bytes() const {
    return bricks_.memory_bytes() + static_cast<std::int64_t>(nodes_.memory_bytes());
}

Eigen::Vector3f leaf_normal(const PointLeaf& leaf) {
    Eigen::Vector3f normal;
    for (int i = 0; i < 3; ++i)
        normal[i] = 2.0F * static_cast<float>(unpack(leaf.normal, i)) /
                        static_cast<float>(PackedTriple::largest(i)) -
                    1.0F;
    return normal;
}

types::Color leaf_color(const PointLeaf& leaf) {
    return {unpack_grey(leaf.color, 0), unpack_grey(leaf.color, 1), unpack_grey(leaf.color, 2)};
}

}  // namespace divemesh::fusion
