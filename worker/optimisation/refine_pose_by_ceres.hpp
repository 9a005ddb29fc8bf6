#pragma once

#include <Eigen/Geometry>

#include "worker/types/rectified_rig.hpp"
#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"

namespace divemesh::worker {

// Step 6 as the paper has it, and the yardstick of refine_pose: rotation (Rodrigues vector) and
// translation by Levenberg-Marquardt from the guess, over the pairs and the inertial unit's word,
// robustly. Scale stays 1. Returns T_current_previous.
Eigen::Isometry3d refine_pose_by_ceres(const RectifiedRig& rig,
                                       const PointPairs& pairs,
                                       const MotionGuess& guess);

}  // namespace divemesh::worker
