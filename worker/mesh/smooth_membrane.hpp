#pragma once

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Smooths noise that is wider than a cell, which surface nets cannot remove: vertices whose
// standard deviation sigma is more than half a voxel move to the minimum of
//   sum over vertices |x - p|^2 / sigma^2  +  sum over sides |x_i - x_j|^2 / (d s^2),
// where p is the measured position, d the number of a vertex's neighbours and s a fifth of its
// voxel: a membrane for a surface that deviates by s from the mean of its neighbours. The residual
// is smoothed likewise and added back (twicing, Tukey 1977), so that round shapes do not shrink. No
// vertex moves by more than three standard deviations. Well-known vertices stay in place. Vertices
// on borders are smoothed along the border and move only along their normal, so that the outline
// stays. Vertices that moved get the normals of their triangles. Solved by Jacobi with Chebyshev's
// acceleration (Golub and Varga 1961); the result is the same to the byte for any number of
// threads. A mesh without sigma_m or voxel_m stays as it is.
void smooth_membrane(types::Mesh& mesh, int num_threads);

}  // namespace divemesh::mesh
