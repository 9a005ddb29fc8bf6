#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "worker/mesh/field_reader.hpp"

namespace divemesh::mesh {

// A block and those that touch it, for reading where levels meet. All its functions give the same
// from each block that a place belongs to, so the mesh has no cracks:
//
// - A lattice point in the middle of an edge or a face of a coarser cell has the mean of that
//   edge's or face's corners, even where it has a sample of its own. So the field is continuous,
//   and cells on both sides of a face see the same crossings.
// - Distances are known within some voxels of the surface. Beside finer blocks a crossed cell may
//   have a corner that is too far away for their voxels: it is extrapolated.
class BlockSurroundings {
public:
    BlockSurroundings(const FieldReader& reader, std::size_t block);

    int level() const { return level_; }
    const Eigen::Vector3i& first_sample() const { return first_sample_; }
    bool one_level() const { return one_level_; }  // no block of another level touches this one

    // Returns the block, of whatever level, that contains a lattice point, or kNone.
    std::size_t find(int level, const Eigen::Vector3i& sample) const;
    // Returns the distance at a lattice point of this block's level, or unknown.
    float distance_m(const Eigen::Vector3i& sample) const;
    // Reads the distances at the eight corners of a cell of this block's level.
    std::array<float, 8> read_cell(const Eigen::Vector3i& cell) const;
    void read(BlockNeighbourhood& out) const;
    // Returns which middles of edges and faces of a cell of this block are corners of finer cells:
    // a bit for each node of RefinedTopology.
    std::uint32_t split_nodes(const Eigen::Vector3i& cell) const;

private:
    void add(std::size_t block, const Eigen::Vector3i& offset);
    void add_finer(const fusion::BlockCoordinate& coarse, const Eigen::Vector3i& offset);
    int level_of(std::size_t block) const { return reader_.field().blocks()[block].level; }
    bool touches_finer(int level, const Eigen::Vector3i& sample) const;
    bool touches_coarser(int level, const Eigen::Vector3i& sample) const;
    float sample_m(int level, const Eigen::Vector3i& sample) const;
    float known_or_extrapolated_m(int level, const Eigen::Vector3i& sample) const;
    float extrapolated_m(int level, const Eigen::Vector3i& sample) const;
    float mean_of_coarser_m(int level, const Eigen::Vector3i& sample, int num_axes) const;

    const FieldReader& reader_;
    std::size_t block_;
    int level_;
    Eigen::Vector3i first_sample_;
    Eigen::Vector3i first_finer_;  // of the level below, where `blocks_` begins
    bool one_level_ = true;
    std::array<std::size_t, 64> blocks_;  // of 4 x 4 x 4 cubes of half the block's size, around it
};

}  // namespace divemesh::mesh
