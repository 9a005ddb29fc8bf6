#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/optimisation/join_path.hpp"

namespace divemesh::optimisation {

// Returns T_site_world, a rotation about the vertical and a translation, that most points agree
// with: of the alignments by each pair of up to 150 points that of the least sum of squared
// residuals, each at most 9 sigmas^2 (MSAC, Torr and Zisserman 2000). `points` must not be empty.
Eigen::Isometry3d align_heading(const std::vector<OutsidePoint>& points);

// Returns the median horizontal residual of an alignment, in the sigmas of the points.
double median_residual_sigmas(const std::vector<OutsidePoint>& points,
                              const Eigen::Isometry3d& T_site_world);

}  // namespace divemesh::optimisation
