#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "worker/types/mesh.hpp"

namespace divemesh::io {

// A cubic lattice on which positions are integers: p_world = low_m + step_m * (x, y, z).
struct PositionLattice {
    Eigen::Vector3d low_m = Eigen::Vector3d::Zero();
    double step_m = 1.0;

    std::array<std::uint16_t, 3> nearest(const Eigen::Vector3f& p_world) const;
    // Returns the largest distance of a position from its nearest point of the lattice.
    double max_error_m() const;
};

// Returns the lattice of the fewest bits, 14 to 16 over the longest side of the mesh, on which no
// position is wrong by more than a tenth of the smallest sigma of the mesh; of 16 bits if there is
// none, or no sigma is known.
PositionLattice position_lattice(const types::Mesh& mesh);

}  // namespace divemesh::io
