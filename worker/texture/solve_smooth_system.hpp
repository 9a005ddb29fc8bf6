#pragma once

#include <Eigen/SparseCore>

#include "worker/base/parallel.hpp"

namespace divemesh::texture {

using SymmetricMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;  // both triangles

// Solves matrix * x = right for a symmetric, positive definite and diagonally dominant matrix, as
// smoothness over a surface gives it: by conjugate gradients, with the solution over groups of
// neighbouring unknowns as preconditioner (Nicolaides, "Deflation of conjugate gradients with
// applications to boundary value problems", 1987), which makes a million unknowns converge in
// dozens of steps. Each channel's residual is reduced to 1e-4 of the right side.
Eigen::MatrixX3d solve_smooth_system(const SymmetricMatrix& matrix,
                                     const Eigen::MatrixX3d& right,
                                     const base::ProgressShare& progress);

}  // namespace divemesh::texture
