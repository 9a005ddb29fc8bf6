#pragma once

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Evens out noise that is wider than a cell, which surface nets cannot: vertices whose standard
// deviation sigma is more than half a voxel move to the minimum of
//   sum over vertices |x - p|^2 / sigma^2  +  sum over sides |x_i - x_j|^2 / (d s^2),
// p the measured places, d a vertex's number of neighbours, s a fifth of a voxel: the membrane of
// a surface that deviates by s from the mean of its neighbours. The same is done with what was
// taken away (twicing, Tukey 1977), so that round things do not shrink. No vertex moves by more
// than three standard deviations. Well-known vertices stay put; borders are evened out along
// themselves and keep their outline: they move along their normal alone. Normals of what moved are
// those of its triangles. Solved by Jacobi with Chebyshev's acceleration (Golub and Varga 1961);
// the number of threads changes no byte.
void smooth_membrane(types::Mesh& mesh, double voxel_m, int num_threads);

}  // namespace divemesh::mesh
