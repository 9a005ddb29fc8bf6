#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "worker/odometry/register_points.hpp"
#include "worker/types/known_rotation.hpp"

namespace divemesh::odometry {

// The predicted motion of step 5, the start of step 6.
struct MotionGuess {
    Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();
    std::optional<types::KnownRotation> rotation;  // q_current_previous from the IMU
    double disagreement_rad = 0.0;                 // between vision and the IMU
};

// Step 5: returns the rotation measured by the IMU and the translation that fits the inliers with
// it. Without an IMU: the motion from vision.
MotionGuess predict_orientation(const std::optional<types::KnownRotation>& q_current_previous,
                                const Registration& motion);

}  // namespace divemesh::odometry
