#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "worker/fusion/signed_distance_field.hpp"

namespace divemesh::mesh {

// Distances of a block and of the first layer of its neighbours: the corners of its cells. A cell
// is the cube between eight samples and belongs to the block of its min corner.
struct BlockNeighbourhood {
    static constexpr int kEdge = fusion::kBlockEdge + 1;
    std::array<float, std::size_t{kEdge} * kEdge * kEdge> distances_m;

    static int index(int x, int y, int z) { return (z * kEdge + y) * kEdge + x; }
};

// Returns the point of level `to` at a lattice point of level `from`; the last one before it where
// `to` is coarser and has none there.
inline Eigen::Vector3i point_at(int from, const Eigen::Vector3i& point, int to) {
    if (to <= from) return point * (1 << (from - to));
    const int shift = to - from;
    return {point.x() >> shift, point.y() >> shift, point.z() >> shift};
}

// Returns the place of a corner in its cell, x running fastest.
inline Eigen::Vector3i corner_offset(int corner) {
    return {corner & 1, (corner >> 1) & 1, (corner >> 2) & 1};
}

// Reads a field by coordinates, across blocks. A cell is given by its level and its min corner.
class FieldReader {
public:
    explicit FieldReader(const fusion::SignedDistanceField& field);

    static constexpr std::size_t kNone = ~std::size_t{0};
    std::size_t find(const fusion::BlockCoordinate& block) const;
    // Returns the block, of whatever level, that contains a lattice point.
    std::size_t find_any(int level, const Eigen::Vector3i& sample) const;
    // Reads a block that no block of another level touches.
    void read(std::size_t block, BlockNeighbourhood& out) const;
    // Reads the distances at the eight corners of a cell, x running fastest, from blocks of its
    // level. Returns false if one is unknown.
    bool read_cell(int level, const Eigen::Vector3i& cell, std::array<float, 8>& corners_m) const;
    // Returns the mean colour, sigma and count over the cell's corners near `place` (in the cell, 0
    // to 1).
    fusion::SampleAttributes attributes(int level,
                                        const Eigen::Vector3i& cell,
                                        const Eigen::Vector3f& place) const;

    // Returns the unit vector away from the surface where it crosses a lattice edge: the mean
    // gradient of the known cells among the four around the edge.
    Eigen::Vector3f edge_normal(int level,
                                const Eigen::Vector3i& sample,
                                int axis,
                                float fraction) const;

    const fusion::SignedDistanceField& field() const { return field_; }
    int min_level() const { return min_level_; }
    int max_level() const { return max_level_; }
    double step_m(int level) const { return std::ldexp(field_.voxel_m(), level); }

private:
    // Visits the samples of other levels that stand for a lattice point, with their shares of it.
    template <typename Visit>
    void visit_other_levels(int level, const Eigen::Vector3i& sample, const Visit& visit) const;
    // Returns the block of each corner of a cell, or kNone where none is of the cell's level.
    std::array<std::size_t, 8> blocks_around(int level, const Eigen::Vector3i& cell) const;

    const fusion::SignedDistanceField& field_;
    int min_level_ = 0;
    int max_level_ = 0;
    std::unordered_map<fusion::BlockCoordinate, std::size_t, fusion::BlockCoordinateHash> index_;
};

// Returns the sign mask of a cell; bit c: corner c is behind the surface.
int sign_mask(const std::array<float, 8>& corners_m);

// The field at a point inside a cell, `place` (0 to 1): trilinear between the corners, and its
// gradient per cell edge.
struct CellPoint {
    float distance_m;
    Eigen::Vector3f gradient_m;
};
CellPoint cell_at(const std::array<float, 8>& corners_m, const Eigen::Vector3f& place);

}  // namespace divemesh::mesh
