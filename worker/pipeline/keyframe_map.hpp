#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "worker/imu/inertial_prior.hpp"
#include "worker/keyframes/keyframe_rule.hpp"
#include "worker/odometry/motion_model.hpp"
#include "worker/optimisation/sliding_window.hpp"
#include "worker/types/rest.hpp"
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
    // Returns true if the features at rest have been replaced, or if the rest has no keyframe yet
    // that stands still. The first rest of a dive needs none: nothing moved before.
    bool due_at_rest(const types::Features& features,
                     const std::optional<std::int64_t>& resting_since_ns) const {
        return rule_.due_at_rest(features) ||
               (is_adjusted() && resting_since_ns && last_ns_ < *resting_since_ns + kSettled_ns);
    }

    // Adds a keyframe, and gives the corrected pose to `motion` and the corrected bias to
    // `inertial`. `rests` are those so far.
    void add(const types::RectifiedFrame& frame,
             const types::Features& features,
             const std::vector<types::Rest>& rests,
             odometry::MotionModel& motion,
             imu::InertialPrior& inertial);

    // Moves keyframes and landmarks, as last estimated, to the track, and the outcomes of the
    // sliding window's solver to its statistics.
    void move_to(types::Track& track) const;

private:
    // A rest begins within a pixel of where the rig stops; from then on it stands.
    static constexpr std::int64_t kSettled_ns = 500'000'000;
    static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();

    // Returns how well the pose of a frame in a rest is known against the last keyframe; nullopt if
    // that one is not of the same rest.
    std::optional<types::MotionSigma> since_last(const types::Rest& rest) const;
    bool began_at_rest(const std::vector<types::Rest>& rests) const;

    keyframes::KeyframeRule rule_;
    optimisation::SlidingWindow sliding_window_;
    types::SolverTally solver_;
    bool is_corrected_ = true;  // the motion model goes on from the last keyframe's pose
    std::int64_t last_ns_ = kNever;
};

}  // namespace divemesh::pipeline
