#pragma once

#include <vector>

#include "worker/types/mesh.hpp"
#include "worker/types/path_uncertainty.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/tracking_segment.hpp"

namespace divemesh::evaluation {

// The error of the scale is shared by all positions of a path: for each it lies along the offset
// from the first pose and is proportional to it. Another measurement of lengths replaces that part
// of the error and leaves the drift of the poses as it is.

// Returns for each pose of the trajectory the offset from the first pose of its segment, in the
// axes of the trajectory's first pose, which are those of its covariance. The distance between
// segments is not measured, so no offset crosses from one to another. Without segments it is one.
std::vector<Eigen::Vector3d> offsets_from_start(
    const types::Trajectory& trajectory, const std::vector<types::TrackingSegment>& segments);

// Returns the covariances with `to_sigma` as the relative sigma of the shared scale in place of
// `from_sigma`; at most 99 % of the variance along an offset is taken for the old scale's.
types::CovarianceTrack with_scale_sigma(const types::CovarianceTrack& covariances,
                                        const std::vector<Eigen::Vector3d>& offsets_from_start,
                                        double from_sigma,
                                        double to_sigma);

// Returns a mesh with `to_sigma` in place of `from_sigma` as the relative sigma of the scale, which
// moves a vertex along its offset from the centre of the path: that stays where it is if the path
// is aligned with the truth by its positions. Each segment has a centre of its own, since segments
// lie side by side along x at distances that are not measured; a vertex belongs to the one whose
// poses are nearest along x. Without segments it is one. The sigma of a vertex is along its normal,
// and never less than its noise.
types::Mesh with_scale_sigma(types::Mesh mesh,
                             const types::Trajectory& trajectory,
                             const std::vector<types::TrackingSegment>& segments,
                             double from_sigma,
                             double to_sigma);

// Returns the uncertainty of the path after all lengths were multiplied by `factor`, because a
// better measurement of the scale asked for it; `sigma` is what that leaves unknown of the shared
// scale, relative to the scaled path.
types::PathUncertainty scaled(const types::PathUncertainty& path, double factor, double sigma);

// Where another measurement of lengths contradicts the scale of a path, either may be right, and
// what is stated covers both. This is the one place that says how: the other scale lies at the end
// of a 95 % interval.

// Returns the relative sigma of the scale that a contradiction adds.
double contradiction_sigma(double scale_contradiction);

// Returns the relative sigma of all lengths: that of the path's own scale and of the contradiction.
double lengths_sigma(const types::PathUncertainty& path);

// Returns the uncertainty of the path with the contradiction as a part of its shared scale.
types::PathUncertainty covering_contradiction(const types::PathUncertainty& path);

}  // namespace divemesh::evaluation
