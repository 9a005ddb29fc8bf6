#pragma once

#include <array>
#include <vector>

#include "worker/mesh/field_reader.hpp"

namespace divemesh::mesh {

// A cell of a block that the surface passes through.
struct CrossedCell {
    Eigen::Vector3i place;           // in the block, 0 to 7
    std::array<float, 8> corners_m;  // all known, not all of one sign
};

// Returns the crossed cells of a block, x running fastest.
std::vector<CrossedCell> find_crossed_cells(const BlockNeighbourhood& samples);

}  // namespace divemesh::mesh
