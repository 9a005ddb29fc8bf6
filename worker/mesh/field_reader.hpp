#pragma once

#include <Eigen/Core>
#include <array>
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

// Reads a field by coordinates, across blocks.
class FieldReader {
public:
    explicit FieldReader(const fusion::SignedDistanceField& field);

    static constexpr std::size_t kNone = ~std::size_t{0};
    std::size_t find(const fusion::BlockCoordinate& block) const;
    void read(std::size_t block, BlockNeighbourhood& out) const;
    // Reads the distances at the eight corners of a cell, x running fastest. Returns false if one
    // is unknown.
    bool read_cell(const Eigen::Vector3i& cell, std::array<float, 8>& corners_m) const;
    // Returns the mean colour, sigma and count over the cell's corners near `place` (in the cell, 0
    // to 1).
    fusion::SampleAttributes attributes(const Eigen::Vector3i& cell,
                                        const Eigen::Vector3f& place) const;

    // Returns the unit vector away from the surface where it crosses a lattice edge: the mean
    // gradient of the known cells among the four around the edge.
    Eigen::Vector3f edge_normal(const Eigen::Vector3i& sample, int axis, float fraction) const;

    const fusion::SignedDistanceField& field() const { return field_; }

private:
    // Returns the block of each corner of a cell, or kNone.
    std::array<std::size_t, 8> blocks_around(const Eigen::Vector3i& cell) const;

    const fusion::SignedDistanceField& field_;
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
