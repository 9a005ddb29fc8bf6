#pragma once

#include <Eigen/Geometry>

#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/refined_pose.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::optimisation {

// Step 6 as in the paper, and the reference for tests of refine_pose: robust Levenberg-Marquardt on
// rotation (Rodrigues vector) and translation from the guess, over the pairs and the IMU's
// rotation. Scale stays 1.
odometry::RefinedPose refine_pose_by_ceres(const types::RectifiedRig& rig,
                                           const odometry::PointPairs& pairs,
                                           const odometry::MotionGuess& guess);

}  // namespace divemesh::optimisation
