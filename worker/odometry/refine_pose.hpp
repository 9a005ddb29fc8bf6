#pragma once

#include <Eigen/Geometry>

#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/refined_pose.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Step 6: refines rotation and translation by Levenberg-Marquardt from the guess, over the pairs
// and the rotation known from the IMU. With m = (u, v, disparity), p the point triangulated from
// m_a, h the projection and R <- exp(w) R, T <- T + t each step:
//
//     e = h(R p + T) - m_b,   C = S_b + J S_a J^T,   J = d h(R p + T) / d m_a
//     min sum huber(e^T C^-1 e) + |log(R q_known^-1)|^2 / sigma^2
//
// C is computed at the start of each step and held constant during it: differentiating it without
// the likelihood's log det C would reward large covariances. Scale stays 1.
RefinedPose refine_pose(const types::RectifiedRig& rig,
                        const PointPairs& pairs,
                        const MotionGuess& guess);

// Returns the covariance of a motion found by refine_pose, the inverse of its normal equations:
// rotation vector (rad), then translation (m), of R <- exp(w) R, T <- T + t.
Eigen::Matrix<double, 6, 6> motion_covariance(const types::RectifiedRig& rig,
                                              const PointPairs& pairs,
                                              const MotionGuess& motion);

// Returns the standard deviation of a motion found by refine_pose in the direction that the pairs
// and the known rotation constrain least, in rad. Translations count as angles at the pairs' median
// depth. It is large if the pairs are too few, too far or nearly on one line.
double max_sigma_rad(const types::RectifiedRig& rig,
                     const PointPairs& pairs,
                     const MotionGuess& motion);

}  // namespace divemesh::odometry
