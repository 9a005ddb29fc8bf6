#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "worker/imu/inertial_prior.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/optimisation/bundle_adjustment.hpp"
#include "worker/optimisation/inertial_factors.hpp"
#include "worker/optimisation/marginalisation.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/landmark.hpp"
#include "worker/types/motion_sigma.hpp"
#include "worker/types/solver_outcome.hpp"

namespace divemesh::optimisation {

// The last keyframes with their features and sensor readings, adjusted together: poses, velocities,
// biases, landmarks and the vertical are all free, so a noisy depth is never taken as exact. Older
// keyframes remain as a marginalisation prior. Without inertial sensors it uses vision alone.
class SlidingWindow {
public:
    // `noise` is that of the readings, as InertialPrior::noise() returns it.
    SlidingWindow(const types::RectifiedRig& rig, const types::ImuNoise& noise)
        : rig_(rig), noise_(noise) {}

    // Adds a keyframe; `readings` are the sensors' at the keyframe and since the previous one. If
    // the rig rested since that one, `at_rest` says how well the keyframe's pose is known against
    // it.
    void add_keyframe(const types::Keyframe& keyframe,
                      const types::Features& features,
                      const imu::SensorReadings& readings,
                      const std::optional<types::MotionSigma>& at_rest = std::nullopt);
    // Records that the rig rests at the last keyframe: its velocity is zero.
    void set_at_rest() { entries_.back().at_rest = true; }
    // Adjusts the keyframes in the window, of which there must be at least two. Returns how the
    // solver ended.
    types::SolverOutcome adjust();

    // Replaces the point measured at t-1 by the landmark, if there is one.
    void use_landmarks(const Eigen::Isometry3d& T_world_previous,
                       odometry::PointPairs& pairs) const;

    bool empty() const { return keyframes_.empty(); }
    const Eigen::Isometry3d& T_world_cam() const { return keyframes_.back().T_world_cam; }
    const BodyState& state() const { return entries_.back().state; }  // of the last keyframe
    const WorldReference& reference() const { return *reference_; }
    const std::vector<types::Keyframe>& keyframes() const { return keyframes_; }
    std::vector<types::Landmark> landmarks() const;  // observed in two keyframes or more

private:
    struct MotionAtRest {
        Eigen::Isometry3d T_before_imu;
        types::MotionSigma sigma;
    };
    struct Entry {
        BodyState state;
        imu::SensorReadings readings;
        std::vector<std::size_t> landmarks;  // observed here
        bool moved = true;                   // since the previous keyframe
        bool at_rest = false;
        std::optional<MotionAtRest> motion_at_rest;  // since the previous keyframe
    };
    std::size_t landmark_of(const types::Feature& feature, const types::Keyframe& keyframe);
    BodyState first_state(const types::Keyframe& keyframe,
                          const imu::SensorReadings& readings) const;
    bool has_moved(const Entry& entry) const;
    // A landmark with all its observations, for the bundle adjustment of the whole dive. The prior
    // contains those before `first_in_window`.
    struct TrackedLandmark {
        types::Landmark whole;
        std::size_t first_in_window = 0;
    };
    void move_keyframe(std::size_t k, const Eigen::Isometry3d& T_world_cam);
    std::size_t first_in_window() const;
    // Returns true if sensor readings connect a keyframe with the previous one.
    bool chained(std::size_t k) const;
    void marginalise_oldest();
    void marginalise_oldest(BundleAdjustment& leaving, std::size_t landmark);
    std::vector<std::size_t> landmarks_in_window() const;
    void add_states(BundleAdjustment& bundle_adjustment);
    void add_observations(BundleAdjustment& bundle_adjustment,
                          types::Landmark& landmark,
                          std::size_t first,
                          std::size_t end);
    void add_landmarks(BundleAdjustment& bundle_adjustment);
    void add_readings(BundleAdjustment& bundle_adjustment);
    void add_zero_velocity(BundleAdjustment& bundle_adjustment, std::size_t k);
    void add_motion_at_rest(BundleAdjustment& bundle_adjustment, std::size_t k);
    void drop_outliers();

    types::RectifiedRig rig_;
    types::ImuNoise noise_;
    std::vector<types::Keyframe> keyframes_;
    std::deque<Entry> entries_;  // a deque keeps addresses, by which the prior identifies states
    std::vector<TrackedLandmark> landmarks_;
    std::unordered_map<std::int64_t, std::size_t> landmark_of_feature_;
    std::unique_ptr<WorldReference> reference_ = std::make_unique<WorldReference>();
    LinearPrior prior_;       // of what has left the window
    std::size_t oldest_ = 0;  // index of the oldest keyframe in the window
};

}  // namespace divemesh::optimisation
