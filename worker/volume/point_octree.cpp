#include "worker/volume/point_octree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace divemesh::worker {
namespace {

constexpr float kPlaceScale = 65536.0F;
constexpr float kNormalScale = 32767.0F;
constexpr float kColorScale = 256.0F;

// A stored mean moved toward a new value by its share.
template <typename Stored>
void move_toward(Stored& mean, float value, float share, float low, float high) {
    const float before = static_cast<float>(mean);
    const float after = std::round(before + share * (value - before));
    mean = static_cast<Stored>(std::clamp(after, low, high));
}

}  // namespace

PointOctree::PointOctree(double leaf_m) : leaf_m_(leaf_m) {
    nodes_.add(Node{});  // the root; as a child, 0 means none
    leaves_.add(PointLeaf{});
}

bool PointOctree::insert(const PointObservation& observation) {
    const Eigen::Vector3d scaled = observation.p_world / leaf_m_;
    constexpr double kLimit = 1 << (kLevels - 1);
    if (!((scaled.array() >= -kLimit).all() && (scaled.array() < kLimit).all())) return false;
    const Eigen::Vector3d corner = scaled.array().floor();
    PointLeaf& leaf = *leaf_at(corner.cast<int>());
    const bool is_new = leaf.weight == 0.0F;
    leaf.weight += observation.weight;
    const float share = is_new ? 1.0F : observation.weight / leaf.weight;
    const Eigen::Vector3f place = kPlaceScale * (scaled - corner).cast<float>();
    for (int axis = 0; axis < 3; ++axis) {
        move_toward(leaf.place[axis], place[axis], share, 0.0F, kPlaceScale - 1.0F);
        move_toward(leaf.normal[axis],
                    kNormalScale * observation.normal[axis],
                    share,
                    -kNormalScale,
                    kNormalScale);
        move_toward(leaf.color[axis],
                    kColorScale * static_cast<float>(observation.color[axis]),
                    share,
                    0.0F,
                    65535.0F);
    }
    if ((is_new || leaf.last_view != observation.view) && leaf.num_views < 255) ++leaf.num_views;
    leaf.last_view = observation.view;
    return true;
}

bool PointOctree::restore(const Eigen::Vector3i& cell, const PointLeaf& leaf) {
    constexpr int kLimit = 1 << (kLevels - 1);
    if (!((cell.array() >= -kLimit).all() && (cell.array() < kLimit).all())) return false;
    *leaf_at(cell) = leaf;
    return true;
}

// Cells are counted from the cube's corner, so that bit kLevels - 1 - level of each coordinate
// chooses the child at that level.
PointLeaf* PointOctree::leaf_at(const Eigen::Vector3i& cell) {
    const Eigen::Vector3i at = cell.array() + (1 << (kLevels - 1));
    const auto parted = static_cast<unsigned>(
        (at.x() ^ path_cell_.x()) | (at.y() ^ path_cell_.y()) | (at.z() ^ path_cell_.z()));
    // The first level whose node is not known to be the last cell's too.
    int level =
        std::min(kLevels - 1, std::max(0, kLevels - static_cast<int>(std::bit_width(parted))));
    while (level > 0 && path_[level] == 0) --level;
    path_cell_ = at;
    std::uint32_t node = path_[level];
    for (;; ++level) {
        path_[level] = node;
        const int shift = kLevels - 1 - level;
        const int child = ((at.x() >> shift) & 1) | (((at.y() >> shift) & 1) << 1) |
                          (((at.z() >> shift) & 1) << 2);
        std::uint32_t next = nodes_[node][child];
        const bool is_leaf = level == kLevels - 1;
        if (next == 0) {
            next = is_leaf ? leaves_.add(PointLeaf{}) : nodes_.add(Node{});
            nodes_[node][child] = next;
        }
        if (is_leaf) return &leaves_[next];
        node = next;
    }
}

const PointLeaf* PointOctree::find(const Eigen::Vector3i& cell) const {
    const Eigen::Vector3i at = cell.array() + (1 << (kLevels - 1));
    if ((at.array() < 0).any() || (at.array() >= (1 << kLevels)).any()) return nullptr;
    std::uint32_t node = 0;
    for (int shift = kLevels - 1; shift >= 0; --shift) {
        const int child = ((at.x() >> shift) & 1) | (((at.y() >> shift) & 1) << 1) |
                          (((at.z() >> shift) & 1) << 2);
        node = nodes_[node][child];
        if (node == 0) return nullptr;
    }
    return &leaves_[node];
}

void PointOctree::for_each(
    const std::function<void(const Eigen::Vector3i&, const PointLeaf&)>& visit) const {
    visit_below(0, 0, Eigen::Vector3i::Constant(-(1 << (kLevels - 1))), visit);
}

void PointOctree::visit_below(
    std::uint32_t node,
    int level,
    const Eigen::Vector3i& first_cell,
    const std::function<void(const Eigen::Vector3i&, const PointLeaf&)>& visit) const {
    const int half = 1 << (kLevels - 1 - level);
    for (int child = 0; child < 8; ++child) {
        const std::uint32_t next = nodes_[node][child];
        if (next == 0) continue;
        const Eigen::Vector3i cell =
            first_cell + half * Eigen::Vector3i(child & 1, (child >> 1) & 1, (child >> 2) & 1);
        if (level == kLevels - 1)
            visit(cell, leaves_[next]);
        else
            visit_below(next, level + 1, cell, visit);
    }
}

Eigen::Vector3d PointOctree::position(const Eigen::Vector3i& cell, const PointLeaf& leaf) const {
    const Eigen::Vector3d place(leaf.place[0], leaf.place[1], leaf.place[2]);
    return leaf_m_ * (cell.cast<double>() + place / static_cast<double>(kPlaceScale));
}

std::int64_t PointOctree::memory_bytes() const {
    return static_cast<std::int64_t>(nodes_.memory_bytes() + leaves_.memory_bytes());
}

}  // namespace divemesh::worker
