#pragma once

#include <limits>

#include "worker/imu/inertial_prior.hpp"
#include "worker/keyframes/keyframe_rule.hpp"
#include "worker/odometry/motion_model.hpp"
#include "worker/optimisation/sliding_window.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// The keyframes and their features; each new keyframe adjusts the sliding window.
class KeyframeMap {
public:
    KeyframeMap(const types::RectifiedRig& rig, const imu::InertialPrior& inertial)
        : rule_(rig), sliding_window_(rig, inertial.noise()) {}

    // Replaces the points measured at t-1 by landmarks.
    void use_landmarks(const Eigen::Isometry3d& T_world_previous,
                       odometry::PointPairs& pairs) const {
        sliding_window_.use_landmarks(T_world_previous, pairs);
    }

    bool empty() const { return last_ns_ == kNever; }
    // Returns true if keyframes have been adjusted, so that velocity and biases are estimated.
    bool is_adjusted() const { return sliding_window_.keyframes().size() > 1; }
    bool due(const types::Features& features, std::int64_t timestamp_ns) {
        return rule_.due(features, timestamp_ns);
    }
    bool due_at_rest(const types::Features& features) const { return rule_.due_at_rest(features); }

    // Adds a keyframe, and gives the corrected pose to `motion` and the corrected bias to
    // `inertial`.
    void add(const types::RectifiedFrame& frame,
             const types::Features& features,
             odometry::MotionModel& motion,
             imu::InertialPrior& inertial);

    // Moves keyframes and landmarks, as last estimated, to the track, and the outcomes of the
    // sliding window's solver to its statistics.
    void move_to(types::Track& track) const;

private:
    static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();

    keyframes::KeyframeRule rule_;
    optimisation::SlidingWindow sliding_window_;
    types::SolverTally solver_;
    std::int64_t last_ns_ = kNever;
};

}  // namespace divemesh::pipeline
