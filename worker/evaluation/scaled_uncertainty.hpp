#pragma once

#include <vector>

#include "worker/types/breaks.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/path_uncertainty.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// The error of the scale is shared by all positions of a path: for each it lies along the offset
// from the first pose and is proportional to it. Another measurement of lengths replaces that part
// of the error and leaves the drift of the poses as it is.

// Returns for each pose of the trajectory the offset from the first pose of its segment, in the
// axes of the trajectory's first pose, which are those of its covariance. The distance between
// segments is not measured, so no offset crosses from one to another.
std::vector<Eigen::Vector3d> offsets_from_start(const types::Trajectory& trajectory,
                                                const std::vector<types::Keyframe>& keyframes,
                                                const types::Breaks& breaks_ns);

// Returns the covariances with `to_sigma` as the relative sigma of the shared scale in place of
// `from_sigma`; at most 99 % of the variance along an offset is taken for the old scale's.
types::CovarianceTrack with_scale_sigma(const types::CovarianceTrack& covariances,
                                        const std::vector<Eigen::Vector3d>& offsets_from_start,
                                        double from_sigma,
                                        double to_sigma);

// Returns the uncertainty of the path after all lengths were multiplied by `factor`, because a
// better measurement of the scale asked for it; `sigma` is what that leaves unknown of the shared
// scale, relative to the scaled path.
types::PathUncertainty scaled(const types::PathUncertainty& path, double factor, double sigma);

}  // namespace divemesh::evaluation
