#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/types/path_uncertainty.hpp"
#include "worker/types/pose_covariance.hpp"

namespace divemesh::optimisation {

// `covariance_m2`: three rows a position, in the axes of the positions.
types::PathUncertainty after_alignment(const std::vector<Eigen::Vector3d>& positions,
                                       const Eigen::MatrixXd& covariance_m2);

// What the errors do, one standard deviation, to a factor on heights that is measured from outside,
// as a depth sensor does: with v the heights less the level that fits them best (a tilt is no error
// of the factor), sqrt(v' P_z v) / v' v. 0 for a path that is level.
double vertical_scale_sigma(const std::vector<Eigen::Vector3d>& positions,
                            const Eigen::MatrixXd& covariance_m2);

// With what following the keyframes adds at the frames between them: errors of their own, which no
// alignment takes away.
types::PathUncertainty with_frames_between(types::PathUncertainty keyframes,
                                           const types::CovarianceTrack& of_keyframes,
                                           const types::CovarianceTrack& of_frames);

// By how much, along one axis, the poses move what is near them; 0: not known.
double shared_sigma_m(const types::PathUncertainty& path);

// What a sum of squares of normal numbers stays below in 95 of 100 cases, by its mean and its
// degrees of freedom: as a multiple of chi-square (Satterthwaite 1946).
double quantile_95(double mean_square, double degrees_of_freedom);
// Of the squared length of a normal vector of this covariance.
double squared_length_95(const Eigen::Matrix3d& covariance);

}  // namespace divemesh::optimisation
