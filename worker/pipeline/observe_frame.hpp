#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "worker/odometry/register_points.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/pipeline/tracking_state.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/known_rotation.hpp"

namespace divemesh::pipeline {

// The motion to a frame as predicted before its features are tracked.
struct PredictedMotion {
    std::optional<types::KnownRotation> rotation;  // by the inertial sensors
    Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();
    bool reliable = true;  // false: the rig may have moved otherwise since
    // The time since the velocity was known from which the IMU predicts the motion, if it does.
    std::optional<double> imu_alone_s = {};

    // Returns the predicted motion if it is reliable.
    std::optional<Eigen::Isometry3d> expected() const {
        return reliable ? std::optional(T_current_previous) : std::nullopt;
    }
};

// A frame after steps 2 to 4.
struct Observed {
    types::Features tracks;
    odometry::PointPairs measured;  // by their depth at both times
    odometry::PointPairs pairs;     // by landmarks where there are
    odometry::Registration vision;
    bool against_imu = false;  // a steady motion followed the scene, elsewhere than the IMU said
    bool predicted = true;     // the features were found where the motion model predicted them
    bool recognised = false;   // a keyframe tells the pose, nothing the motion from the last frame
};

// Returns the frame with the motion of its tracks. Features that have just appeared confirm a
// motion of the known scene, but do not outvote it.
Observed observe_frame(TrackingState& state,
                       const types::RectifiedFrame& frame,
                       types::Features tracks,
                       const PredictedMotion& prediction);

}  // namespace divemesh::pipeline
