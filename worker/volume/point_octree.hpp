#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "worker/volume/mesh.hpp"

namespace divemesh::worker {

// One point as a view saw it.
struct PointObservation {
    Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, toward the camera
    Color color = {0, 0, 0};
    float weight = 1.0F;    // 1 / variance of the depth, 1/m^2
    std::uint8_t view = 0;  // number of the view, modulo 256
};

// All that was seen in one leaf, in 24 bytes: weighted means, not the observations.
struct PointLeaf {
    float weight = 0.0F;                   // sum
    std::array<std::uint16_t, 3> place{};  // in the leaf, 1/65536 of its edge
    std::array<std::int16_t, 3> normal{};  // mean, 1/32767
    std::array<std::uint16_t, 3> color{};  // 1/256 grey values
    std::uint8_t num_views = 0;            // up to 255
    std::uint8_t last_view = 0;
};
static_assert(sizeof(PointLeaf) == 24);

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
    static constexpr int kShift = 16;
    static constexpr std::uint32_t kMask = (1U << kShift) - 1;
    std::vector<std::unique_ptr<T[]>> pieces_;
    std::uint32_t size_ = 0;
};

// The paper's octree of points: cubes of 2^20 leaves a side around the world's origin, halved down
// to leaves of `leaf_m`. Nodes exist where there are points; tens of millions of leaves fit, at 24
// bytes each and some 10 bytes of nodes above them on a surface. Neighbouring points go down from
// where their paths part. One thread at a time may insert.
class PointOctree {
public:
    explicit PointOctree(double leaf_m);

    // False when the point is not finite or outside of the cube (+-524288 leaves).
    bool insert(const PointObservation& observation);
    // Puts a leaf back as it was; for loading.
    bool restore(const Eigen::Vector3i& cell, const PointLeaf& leaf);

    const PointLeaf* find(const Eigen::Vector3i& cell) const;  // null: empty
    // Every leaf with its cell, (x, y, z) / leaf_m rounded down, in Morton order: eight by eight by
    // eight aligned cells come one after the other.
    void for_each(const std::function<void(const Eigen::Vector3i&, const PointLeaf&)>& visit) const;

    Eigen::Vector3d position(const Eigen::Vector3i& cell, const PointLeaf& leaf) const;
    double leaf_m() const { return leaf_m_; }
    std::uint32_t num_points() const { return leaves_.size() - 1; }
    std::int64_t memory_bytes() const;

private:
    static constexpr int kLevels = 20;
    using Node =
        std::array<std::uint32_t, 8>;  // children: nodes, at the last level leaves; 0: none

    PointLeaf* leaf_at(const Eigen::Vector3i& cell);
    void visit_below(
        std::uint32_t node,
        int level,
        const Eigen::Vector3i& first_cell,
        const std::function<void(const Eigen::Vector3i&, const PointLeaf&)>& visit) const;

    double leaf_m_;
    Pool<Node> nodes_;
    Pool<PointLeaf> leaves_;
    std::array<std::uint32_t, kLevels> path_{};  // nodes down to the last cell
    Eigen::Vector3i path_cell_ = Eigen::Vector3i::Zero();
};

inline Eigen::Vector3f leaf_normal(const PointLeaf& leaf) {
    return Eigen::Vector3f(leaf.normal[0], leaf.normal[1], leaf.normal[2]) / 32767.0F;
}
inline Color leaf_color(const PointLeaf& leaf) {
    return {static_cast<std::uint8_t>(leaf.color[0] >> 8),
            static_cast<std::uint8_t>(leaf.color[1] >> 8),
            static_cast<std::uint8_t>(leaf.color[2] >> 8)};
}

}  // namespace divemesh::worker
