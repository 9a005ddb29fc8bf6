#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "worker/recording.hpp"
#include "worker/steps/register_points.hpp"

namespace divemesh::worker {

// How far an orientation that the inertial unit gives is to be trusted.
struct KnownRotation {
    Eigen::Quaterniond q;
    double sigma_rad = 0.0;
};

struct MotionGuess {
    Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();
    std::optional<KnownRotation> rotation;  // q_current_previous by the inertial unit
    double disagreement_rad = 0.0;          // of vision with it
};

// Step 5: the orientation that the inertial unit's change of orientation predicts, and the
// translation that goes with it over the inliers. Without a unit: what vision said.
MotionGuess predict_orientation(const std::optional<KnownRotation>& q_current_previous,
                                const Registration& motion);

}  // namespace divemesh::worker
