#pragma once

#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/keyframes/keyframe_rule.hpp"
#include "worker/keyframes/mapping_rule.hpp"
#include "worker/odometry/motion_model.hpp"
#include "worker/odometry/track_summary.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/stereo/match_stereo.hpp"
#include "worker/features/track_features.hpp"
#include "worker/pipeline/track_frames.hpp"
#include "worker/odometry/dynamic_features.hpp"

namespace divemesh::worker {

// The method of the paper: every frame is matched densely and registered to the frame before. What
// one frame says is never looked at again.
class PairwiseTracker : public FrameTracker {
public:
    PairwiseTracker(const RectifiedRig& rig,
                    const Recording& recording,
                    const ReconstructionOptions& options);

    TrackedFrame process(const RectifiedFrame& frame) override;
    void move_to(Track& track) override;

private:
    RectifiedRig rig_;
    ReconstructionOptions options_;
    StereoMatcher stereo_;
    FeatureTracker tracker_;
    InertialPrior inertial_;
    MotionModel motion_;
    DynamicFeatures moving_;
    KeyframeRule keyframe_rule_;
    MappingRule mapping_rule_;
    Features features_;  // of the scene, as the last frame had them
    std::vector<Keyframe> keyframes_;
    TrackSummary summary_;
};

// Tracks all frames of a recording by the method of the paper.
Track track_pairwise(Recording& recording,
                     const ReconstructionOptions& options,
                     const KeyframeStore& store,
                     const ProgressCallback& progress);

}  // namespace divemesh::worker
