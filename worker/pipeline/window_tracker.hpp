#pragma once

#include <optional>

#include "schemas/reconstruction_options.hpp"
#include "worker/imu/sensor_watch.hpp"
#include "worker/keyframes/mapping_rule.hpp"
#include "worker/odometry/imu_aligner.hpp"
#include "worker/odometry/imu_check.hpp"
#include "worker/odometry/track_summary.hpp"
#include "worker/pipeline/observe_frame.hpp"
#include "worker/pipeline/recovery.hpp"
#include "worker/pipeline/rest_watch.hpp"
#include "worker/pipeline/track_frames.hpp"
#include "worker/pipeline/tracking_state.hpp"
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
    bool must_restart() const override { return sensors_.restart().has_value(); }
    void move_to(types::Track& track) override;

    const imu::SensorWatch& sensors() const { return sensors_; }

private:
    // Returns the frame with its right image at the time of the left one, if that was exposed at
    // another time and the motion is known.
    types::RectifiedFrame synchronised(const types::RectifiedFrame& frame,
                                       const PredictedMotion& prediction) const;
    // Steps 2 to 4, by descriptors where the prediction does not reach.
    Observed observe(const types::RectifiedFrame& frame, const PredictedMotion& prediction);
    // Steps 2 to 4 as if there was no IMU. Returns nullopt if that follows the scene no better, or
    // if the IMU predicted nothing.
    std::optional<Observed> observe_without_imu(const types::RectifiedFrame& frame,
                                                const PredictedMotion& prediction);
    // Leaves the IMU out between two frames if vision contradicts what it predicted; returns false
    // then.
    bool check_imu(const Observed& seen,
                   const PredictedMotion& prediction,
                   const types::TimeInterval& time);
    // Takes the features to follow from the frame.
    void choose_features(const types::RectifiedFrame& frame,
                         const Observed& seen,
                         const Eigen::Isometry3d& T_current_previous);
    // Compares the sensors with what vision measured.
    void watch_sensors(const Observed& seen, std::int64_t before_ns, std::int64_t now_ns);
    // Records whether vision follows the scene, by pairs of features of which some are known.
    // Returns true for the first frame that it follows if the scene was lost from the start.
    bool note_sight(const odometry::Registration& vision, const odometry::PointPairs& known);
    // Keeps the frame as a keyframe if one is due, and looks for new features where they are few.
    // Returns true if it was kept.
    bool keep_if_due(const types::RectifiedFrame& frame, const odometry::Registration& vision);
    // Returns the frame's data for mapping; nullopt if it is not mapped.
    std::optional<FrameToMap> to_map(const types::RectifiedFrame& frame,
                                     const odometry::Registration& vision,
                                     bool kept);

    TrackingState state_;
    Recovery recovery_;
    RestWatch rest_;
    odometry::ImuCheck imu_check_;
    odometry::ImuAligner aligner_;
    imu::SensorWatch sensors_;
    keyframes::MappingRule mapping_rule_;
    int last_frame_;
    std::optional<features::DescribedKeypoints> view_;  // of a keyframe, for loop closure
    bool ever_found_ = false;                           // vision has measured a motion
    bool lost_from_start_ = false;  // vision has not followed the first keyframe
    odometry::TrackSummary summary_;
};

// Tracks all frames of a recording with a sliding window. If a sensor turns out to contradict the
// images, it starts anew without it, or with the clock's offset that was found.
types::Track track_window(types::Recording& recording,
                          const ReconstructionOptions& options,
                          const keyframes::KeyframeStore& store,
                          const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
