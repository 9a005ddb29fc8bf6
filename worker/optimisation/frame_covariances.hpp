#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/types/keyframe.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::optimisation {

// Of every frame: linearly between those of the keyframes, beyond their ends as at the end; and
// what the odometry that it follows them by adds. That errs by independent steps, as far as it
// misses from one keyframe to the next, median over the dive or here, whichever is more; tied to
// keyframes at both ends its error is a Brownian bridge.
types::CovarianceTrack covariances_at(const types::CovarianceTrack& covariances,
                                      const types::Trajectory& odometry,
                                      const std::vector<types::Keyframe>& keyframes,
                                      const Eigen::Isometry3d& T_imu_cam);

}  // namespace divemesh::optimisation
