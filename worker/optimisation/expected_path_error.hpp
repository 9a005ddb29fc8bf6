#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/types/path_uncertainty.hpp"
#include "worker/types/pose_covariance.hpp"

namespace divemesh::optimisation {

// Returns the expected error after alignment. `covariance_m2` has three rows per position, in the
// positions' axes.
types::PathUncertainty after_alignment(const std::vector<Eigen::Vector3d>& positions,
                                       const Eigen::MatrixXd& covariance_m2);

// Returns the standard deviation of a scale factor of heights caused by the errors, when the factor
// is measured against an outside reference such as a depth sensor. With v the heights minus the
// plane that fits them best (a tilt does not change the factor): sqrt(v' P_z v) / v' v. 0 for a
// level path.
double vertical_scale_sigma(const std::vector<Eigen::Vector3d>& positions,
                            const Eigen::MatrixXd& covariance_m2);

// Returns the mean square distance of the positions from their centre.
double spread_m2(const std::vector<Eigen::Vector3d>& positions);

// Returns the standard deviation of the scale factor that maps the true path to the estimated one.
// With v the positions from their centre: sqrt(v' P v) / v' v. 0 for a single place.
double scale_sigma(const std::vector<Eigen::Vector3d>& positions,
                   const Eigen::MatrixXd& covariance_m2);

// Adds the errors of the frames between keyframes; they are independent, so no alignment removes
// them.
types::PathUncertainty with_frames_between(types::PathUncertainty keyframes,
                                           const types::CovarianceTrack& of_keyframes,
                                           const types::CovarianceTrack& of_frames);

// Returns the standard deviation, along one axis, of how far the poses' errors move what is near
// them; 0: unknown.
double shared_sigma_m(const types::PathUncertainty& path);

// Returns the 95 % quantile of a sum of squares of normal variables, given its mean and degrees of
// freedom, as a multiple of chi-square (Satterthwaite 1946).
double quantile_95(double mean_square, double degrees_of_freedom);
// Returns the same quantile of the squared length of a normally distributed vector with this
// covariance.
double squared_length_95(const Eigen::Matrix3d& covariance);

}  // namespace divemesh::optimisation
