#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "worker/volume/block_coordinate.hpp"
#include "worker/volume/mesh.hpp"
#include "worker/volume/spill_store.hpp"

namespace divemesh::worker {

// One point as a view saw it.
struct PointObservation {
    Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, toward the camera
    Color color = {0, 0, 0};
    float weight = 1.0F;    // 1 / variance of the depth, 1/m^2
    std::uint8_t view = 0;  // number of the view, modulo 256
};

// All that was seen in one leaf, in 16 bytes: weighted means, not the observations; packed as
// worker/volume/packed_values.hpp says.
struct PointLeaf {
    std::uint16_t weight = 0;    // sum
    std::uint8_t num_views = 0;  // up to 255
    std::uint8_t last_view = 0;
    std::uint32_t place = 0;   // in the leaf, shares of its edge
    std::uint32_t normal = 0;  // mean; from -1 to 1
    std::uint32_t color = 0;   // red, green, blue
};
static_assert(sizeof(PointLeaf) == 16);

// A grow-only array in pieces: never copied, so that it never needs twice its memory.
template <typename T>
class Pool {
public:
    std::uint32_t add(const T& value) {
        if ((size_ & kMask) == 0) pieces_.push_back(std::make_unique<T[]>(kMask + 1));
        pieces_.back()[size_ & kMask] = value;
        return size_++;
    }
    T& operator[](std::uint32_t i) { return pieces_[i >> kShift][i & kMask]; }
    const T& operator[](std::uint32_t i) const { return pieces_[i >> kShift][i & kMask]; }
    std::uint32_t size() const { return size_; }
    std::size_t memory_bytes() const { return pieces_.size() * sizeof(T) * (kMask + 1); }

private:
    static constexpr int kShift = 12;
    static constexpr std::uint32_t kMask = (1U << kShift) - 1;
    std::vector<std::unique_ptr<T[]>> pieces_;
    std::uint32_t size_ = 0;
};

// The paper's octree of points: cubes of 2^20 leaves a side around the world's origin, halved down
// to leaves of `leaf_m`. Nodes exist where there are points. The lowest three levels are one brick:
// a bit for each of its 8 x 8 x 8 leaves, and those that exist one after the other. Tens of
// millions of leaves fit, at 16 bytes each and about two more for bricks and nodes on a surface;
// leaves that were not in view of late go to disk when there are many. One thread at a time.
class PointOctree {
public:
    explicit PointOctree(double leaf_m, SpillSettings spill = {});

    // False when the point is not finite or outside of the cube (+-524288 leaves).
    bool insert(const PointObservation& observation);
    // Puts a leaf back as it was; for loading.
    bool restore(const Eigen::Vector3i& cell, const PointLeaf& leaf);

    const PointLeaf* find(const Eigen::Vector3i& cell) const;  // null: empty
    // Every leaf with its cell, (x, y, z) / leaf_m rounded down, brick by brick in Morton order.
    void for_each(const std::function<void(const Eigen::Vector3i&, const PointLeaf&)>& visit) const;
    // Leaves beyond what may be in memory go; no pointer to a leaf outlives it.
    void trim() const { leaves_.trim(); }

    Eigen::Vector3d position(const Eigen::Vector3i& cell, const PointLeaf& leaf) const;
    double leaf_m() const { return leaf_m_; }
    std::int64_t num_points() const { return num_points_; }
    std::int64_t size_bytes() const;    // in memory and on disk
    std::int64_t memory_bytes() const;  // in memory

private:
    static constexpr int kRoom = 8;
    static constexpr int kLeafLevels = 20;
    static constexpr int kLevels = kLeafLevels - 3;  // of bricks
    // Children: nodes, at the last level bricks; 0: none.
    using Node = std::array<std::uint32_t, 8>;
    struct Brick {
        std::array<std::uint64_t, kBlockEdge> occupied{};    // by layer z: bit 8 y + x
        std::array<std::uint16_t, kBlockEdge> num_before{};  // leaves in the layers below
        // Leaves by rank, kRoom in each; further ones in `overflow_`.
        std::array<SpillStore::Handle, 8> rooms{};
        std::uint32_t overflow = 0;
        int num_leaves = 0;

        int rank(int place) const;  // of a leaf among those that exist
        bool holds(int place) const { return ((occupied[place >> 6] >> (place & 63)) & 1) != 0; }
    };
    using Overflow = std::array<SpillStore::Handle, kBlockSamples / kRoom - 8>;
    using Visit = std::function<void(const Eigen::Vector3i&, const PointLeaf&)>;

    static bool inside(const Eigen::Vector3i& cell);
    std::uint32_t brick_at(const Eigen::Vector3i& brick);
    PointLeaf& leaf_at(const Eigen::Vector3i& cell);
    PointLeaf& make_leaf(Brick& brick, int place);
    void add_room(Brick& brick);
    SpillStore::Handle room(const Brick& brick, int number) const;
    PointLeaf* write_room(const Brick& brick, int number);
    const PointLeaf* read_room(const Brick& brick, int number) const;
    void visit_below(std::uint32_t node,
                     int level,
                     const Eigen::Vector3i& first_brick,
                     const Visit& visit) const;
    void visit_brick(std::uint32_t brick,
                     const Eigen::Vector3i& coordinate,
                     const Visit& visit) const;

    double leaf_m_;
    Pool<Node> nodes_;
    Pool<Brick> bricks_;
    Pool<Overflow> overflow_;
    SpillStore leaves_;
    std::int64_t num_points_ = 0;
    std::array<std::uint32_t, kLevels> path_{};  // nodes down to the last brick
    Eigen::Vector3i last_at_ = Eigen::Vector3i::Zero();
    std::uint32_t last_brick_ = 0;
};

Eigen::Vector3f leaf_normal(const PointLeaf& leaf);  // its length tells how much normals agree
Color leaf_color(const PointLeaf& leaf);

}  // namespace divemesh::worker
