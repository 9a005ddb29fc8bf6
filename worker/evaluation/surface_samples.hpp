#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::evaluation {

// Returns the sum of the triangles' areas.
double surface_area_m2(const types::Mesh& mesh);

// Returns points distributed uniformly over the area: one in each of num_samples equal shares of
// it, in the order of the triangles, at a position that depends only on the seed and the sample
// number. Throws Error{BadData} if the mesh has no area.
std::vector<Eigen::Vector3f> sample_surface(const types::Mesh& mesh,
                                            std::int64_t num_samples,
                                            std::uint64_t seed);

}  // namespace divemesh::evaluation
