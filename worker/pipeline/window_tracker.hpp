#pragma once

#include <optional>

#include "schemas/reconstruction_options.hpp"
#include "worker/odometry/imu_aligner.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/pipeline/keyframe_map.hpp"
#include "worker/loops/relocaliser.hpp"
#include "worker/keyframes/mapping_rule.hpp"
#include "worker/odometry/motion_model.hpp"
#include "worker/odometry/track_summary.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/features/track_features.hpp"
#include "worker/pipeline/track_frames.hpp"
#include "worker/odometry/dynamic_features.hpp"

namespace divemesh::worker {

// The steps of the paper with landmarks of a sliding window in place of the points measured at t-1,
// and with depth at the features alone.
class WindowTracker : public FrameTracker {
public:
    WindowTracker(const RectifiedRig& rig,
                  const Recording& recording,
                  const ReconstructionOptions& options);

    TrackedFrame process(const RectifiedFrame& frame) override;
    void move_to(Track& track) override;

private:
    // Returns what the keyframe is recognised by; nullopt: no loop is looked for.
    std::optional<DescribedKeypoints> keep_keyframe(const RectifiedFrame& frame);

    RectifiedRig rig_;
    ReconstructionOptions options_;
    FeatureTracker tracker_;
    InertialPrior inertial_;
    ImuAligner aligner_;
    KeyframeMap map_;
    Relocaliser memory_;
    MappingRule mapping_rule_;
    MotionModel motion_;
    DynamicFeatures moving_;
    Features features_;  // of the scene, as the last frame had them
    TrackSummary summary_;
};

// Tracks all frames of a recording with a sliding window.
Track track_window(Recording& recording,
                   const ReconstructionOptions& options,
                   const KeyframeStore& store,
                   const ProgressCallback& progress);

}  // namespace divemesh::worker
