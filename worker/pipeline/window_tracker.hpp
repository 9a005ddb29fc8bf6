#pragma once

#include <optional>

#include "schemas/reconstruction_options.hpp"
#include "worker/features/track_features.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/imu/sensor_watch.hpp"
#include "worker/keyframes/mapping_rule.hpp"
#include "worker/loops/relocaliser.hpp"
#include "worker/odometry/dynamic_features.hpp"
#include "worker/odometry/imu_aligner.hpp"
#include "worker/odometry/known_scene.hpp"
#include "worker/odometry/motion_model.hpp"
#include "worker/odometry/rest_detector.hpp"
#include "worker/odometry/track_summary.hpp"
#include "worker/pipeline/keyframe_map.hpp"
#include "worker/pipeline/track_frames.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::pipeline {

// A tracker by the steps of the paper, but with the landmarks of a sliding window instead of the
// points measured at t-1, and with depth at the features only.
class WindowTracker : public FrameTracker {
public:
    WindowTracker(const types::RectifiedRig& rig,
                  const types::Recording& recording,
                  const ReconstructionOptions& options,
                  const imu::SensorPlan& plan);

    TrackedFrame process(const types::RectifiedFrame& frame) override;
    bool in_vain() const override { return sensors_.restart().has_value(); }
    void move_to(types::Track& track) override;

    const imu::SensorWatch& sensors() const { return sensors_; }

private:
    // Steps 2 to 4 for one frame.
    struct Observed {
        types::Features tracks;
        odometry::PointPairs measured;  // by their depth at both times
        odometry::PointPairs pairs;     // by landmarks where there are
        odometry::Registration vision;
        bool predicted = true;  // the features were found where the motion model predicted them
    };
    Observed observe(const types::RectifiedFrame& frame,
                     types::Features tracks,
                     const std::optional<types::KnownRotation>& rotation,
                     const Eigen::Isometry3d& expected);
    // Returns the motion of the pairs. Features that have just appeared do not outvote the known
    // scene.
    odometry::Registration register_pairs(const types::RectifiedFrame& frame,
                                          const odometry::PointPairs& pairs,
                                          const std::optional<types::KnownRotation>& rotation,
                                          const Eigen::Isometry3d& expected) const;
    // Registers the frame by descriptors, to the previous frame or to one of the last keyframes,
    // and tracks its features again from there. Returns what supports the motion best.
    Observed recover(const types::RectifiedFrame& frame,
                     const std::optional<types::KnownRotation>& rotation,
                     const Eigen::Isometry3d& expected,
                     Observed predicted);
    std::optional<Observed> follow_wide(const types::RectifiedFrame& frame,
                                        const loops::MotionPrior& prior);
    std::optional<Observed> recognise(const types::RectifiedFrame& frame,
                                      const std::optional<types::KnownRotation>& rotation,
                                      const Eigen::Isometry3d& expected);
    // Returns T_current_previous of a rig that hardly moves; nullopt if it moves.
    std::optional<Eigen::Isometry3d> watch_rest(const odometry::Registration& vision,
                                                const Eigen::Isometry3d& estimated,
                                                std::int64_t now_ns);
    bool turns_by_gyroscope(std::int64_t now_ns) const;
    // Uses that the rig has hardly moved for some time.
    void rest(std::int64_t now_ns);
    // Compares the sensors with what vision measured.
    void watch_sensors(const odometry::PointPairs& measured,
                       const odometry::Registration& vision,
                       std::int64_t before_ns,
                       std::int64_t now_ns);
    // Returns the keypoints of the keyframe; nullopt: loops are not searched for.
    std::optional<features::DescribedKeypoints> keep_keyframe(const types::RectifiedFrame& frame);

    types::RectifiedRig rig_;
    ReconstructionOptions options_;
    features::FeatureTracker tracker_;
    imu::InertialPrior inertial_;
    odometry::ImuAligner aligner_;
    imu::SensorWatch sensors_;
    KeyframeMap map_;
    loops::Relocaliser memory_;
    keyframes::MappingRule mapping_rule_;
    odometry::MotionModel motion_;
    odometry::DynamicFeatures moving_;
    odometry::KnownScene scene_;
    odometry::RestDetector rest_;
    types::Features features_;  // static ones, as the last frame had them
    odometry::TrackSummary summary_;
};

// Tracks all frames of a recording with a sliding window. If a sensor turns out to contradict the
// images, it starts anew without it, or with the clock's offset that was found.
types::Track track_window(types::Recording& recording,
                          const ReconstructionOptions& options,
                          const keyframes::KeyframeStore& store,
                          const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
