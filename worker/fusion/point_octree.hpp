#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "worker/fusion/brick_store.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::fusion {

// One point as a view saw it.
struct PointObservation {
    Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, toward the camera
    types::Color color = {0, 0, 0};
    float weight = 1.0F;    // 1 / variance of the depth, 1/m^2
    std::uint8_t view = 0;  // number of the view, modulo 256
};

// A grow-only array in chunks: it is never copied, so it never needs twice its memory.
template <typename T>
class Pool {
public:
    std::uint32_t add(const T& value) {
        if ((size_ & kMask) == 0) chunks_.push_back(std::make_unique<T[]>(kMask + 1));
        chunks_.back()[size_ & kMask] = value;
        return size_++;
    }
    T& operator[](std::uint32_t i) { return chunks_[i >> kShift][i & kMask]; }
    const T& operator[](std::uint32_t i) const { return chunks_[i >> kShift][i & kMask]; }
    std::uint32_t size() const { return size_; }
    std::size_t memory_bytes() const { return chunks_.size() * sizeof(T) * (kMask + 1); }

private:
    static constexpr int kShift = 12;
    static constexpr std::uint32_t kMask = (1U << kShift) - 1;
    std::vector<std::unique_ptr<T[]>> chunks_;
    std::uint32_t size_ = 0;
};

// The paper's octree of points: a cube of 2^20 leaves a side around the world's origin, halved down
// to leaves of `leaf_m`. Nodes exist only where there are points. The lowest three levels are one
// brick. It holds tens of millions of leaves, at 19 bytes each and about 40 more for a brick and
// the nodes above it; leaves that were not in view lately are spilled to disk. For one thread at a
// time.
class PointOctree {
public:
    explicit PointOctree(double leaf_m, SpillSettings spill = {});
    PointOctree(const PointOctree&) = delete;  // its bricks call back when they move
    PointOctree& operator=(const PointOctree&) = delete;

    // Adds an observation to its leaf. Returns false if the point is not finite or outside the cube
    // (+-524288 leaves).
    bool insert(const PointObservation& observation);
    // Restores a leaf when a volume is loaded.
    bool restore(const Eigen::Vector3i& cell, const PointLeaf& leaf);

    const PointLeaf* find(const Eigen::Vector3i& cell) const;  // Returns null if the leaf is empty.
    // Visits every leaf with its cell, (x, y, z) / leaf_m rounded down, brick by brick in Morton
    // order.
    void for_each(const std::function<void(const Eigen::Vector3i&, const PointLeaf&)>& visit) const;
    // Spills leaves beyond the memory limit. Invalidates all pointers to leaves.
    void trim() const { bricks_.trim(); }

    Eigen::Vector3d position(const Eigen::Vector3i& cell, const PointLeaf& leaf) const;
    double leaf_m() const { return leaf_m_; }
    std::int64_t num_points() const { return bricks_.num_leaves(); }
    std::int64_t size_bytes() const;    // in memory and on disk
    std::int64_t memory_bytes() const;  // in memory

private:
    static constexpr int kLeafLevels = 20;
    static constexpr int kLevels = kLeafLevels - 3;  // of bricks
    // Children of a node: nodes, at the last level handles of bricks plus one; 0: no child. The
    // owner of a brick is 8 times its node plus its number in it.
    using Node = std::array<std::uint32_t, 8>;
    using Visit = std::function<void(const Eigen::Vector3i&, const PointLeaf&)>;

    static bool inside(const Eigen::Vector3i& cell);
    BrickStore::Handle brick_at(const Eigen::Vector3i& brick);
    PointLeaf& leaf_at(const Eigen::Vector3i& cell);
    void visit_below(std::uint32_t node,
                     int level,
                     const Eigen::Vector3i& first_brick,
                     const Visit& visit) const;
    void visit_brick(BrickStore::Handle brick,
                     const Eigen::Vector3i& coordinate,
                     const Visit& visit) const;

    double leaf_m_;
    Pool<Node> nodes_;
    BrickStore bricks_;
    std::array<std::uint32_t, kLevels> path_{};  // nodes down to the last brick
    Eigen::Vector3i last_at_ = Eigen::Vector3i::Zero();
};

Eigen::Vector3f leaf_normal(const PointLeaf& leaf);  // the better the normals agree, the longer
types::Color leaf_color(const PointLeaf& leaf);

}  // namespace divemesh::fusion
