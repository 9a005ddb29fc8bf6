#pragma once

#include <optional>

#include "schemas/reconstruction_options.hpp"
#include "worker/estimation/imu_aligner.hpp"
#include "worker/estimation/inertial_prior.hpp"
#include "worker/estimation/keyframe_map.hpp"
#include "worker/estimation/loops/relocaliser.hpp"
#include "worker/estimation/mapping_rule.hpp"
#include "worker/estimation/motion_model.hpp"
#include "worker/estimation/track_summary.hpp"
#include "worker/geometry/rectified_rig.hpp"
#include "worker/steps/track_features.hpp"
#include "worker/track_frames.hpp"
#include "worker/tracking/dynamic_features.hpp"

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
