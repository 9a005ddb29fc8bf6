#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "worker/odometry/register_points.hpp"
#include "worker/types/known_rotation.hpp"

namespace divemesh::odometry {

struct MotionGuess {
    Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();
    std::optional<types::KnownRotation> rotation;  // q_current_previous by the inertial unit
    double disagreement_rad = 0.0;                 // of vision with it
};

// Step 5: the orientation that the inertial unit's change of orientation predicts, and the
// translation that goes with it over the inliers. Without a unit: what vision said.
MotionGuess predict_orientation(const std::optional<types::KnownRotation>& q_current_previous,
                                const Registration& motion);

}  // namespace divemesh::odometry
