#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/types/breaks.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/motion_sigma.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::optimisation {

// Returns the covariance of every frame: interpolated linearly between keyframes (constant outside)
// plus the error of the odometry between them. That error is a random walk by the variances of the
// steps (`sigmas`, of the step to each frame), scaled by how far the odometry misses the next
// keyframe: the larger of the median over the dive and the local value. As it is tied to keyframes
// at both ends, it is a Brownian bridge; beside a motion that was not measured (`breaks_ns`) it is
// tied to one keyframe, and grows with the steps from it.
types::CovarianceTrack covariances_at(const types::CovarianceTrack& covariances,
                                      const types::Trajectory& odometry,
                                      const std::vector<types::MotionSigma>& sigmas,
                                      const std::vector<types::Keyframe>& keyframes,
                                      const Eigen::Isometry3d& T_imu_cam,
                                      const types::Breaks& breaks_ns = {});

}  // namespace divemesh::optimisation
