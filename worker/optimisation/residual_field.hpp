#pragma once

#include <Eigen/Core>

#include "worker/optimisation/reduced_information.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::optimisation {

// Errors that are fixed in the image: the part of a lens that its model does not describe (Schoeps
// et al., "Why having 10,000 parameters in your camera model is better than twelve", 2020). A field
// of (u, v, disparity) that is linear between the nodes of a grid. Finer fields carry less
// information about the path, coarser ones are part of the lens model.
constexpr int kFieldColumns = 7;
constexpr int kFieldRows = 5;
constexpr int kFieldSize = 3 * kFieldColumns * kFieldRows;

// Returns d(u, v, disparity)/d(nodes) at a measurement in the rectified image.
Eigen::Matrix<double, 3, kFieldSize> by_field(const types::RectifiedRig& rig,
                                              const Eigen::Vector3d& measured_px);

// Returns the variance of the nodes that the residuals show, px^2; 0 if they show none. The field
// has the columns of B from `first` on. With g the summed scores of the nodes at the solution, V
// what they would vary by if landmarks erred independently, and M their information after all else
// is eliminated, nodes of variance s^2 make
//
//     E |g|^2 = tr V + s^2 |M|^2
//
// solved for s^2 by the method of moments (Rao, "Estimation of variance and covariance components",
// 1971). `moved` is H^-1 B for all columns.
double field_variance(const ClusteredInformation& information,
                      const Eigen::MatrixXd& moved,
                      Eigen::Index first);

}  // namespace divemesh::optimisation
