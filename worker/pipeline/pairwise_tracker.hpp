#pragma once

#include <optional>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/features/track_features.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/keyframes/keyframe_rule.hpp"
#include "worker/keyframes/mapping_rule.hpp"
#include "worker/odometry/dynamic_features.hpp"
#include "worker/odometry/motion_model.hpp"
#include "worker/odometry/track_summary.hpp"
#include "worker/pipeline/track_frames.hpp"
#include "worker/stereo/match_stereo.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::pipeline {

// A tracker by the paper's method: every frame is matched densely and registered to the previous
// one. Earlier frames are not used again.
class PairwiseTracker : public FrameTracker {
public:
    PairwiseTracker(const types::RectifiedRig& rig,
                    const types::Recording& recording,
                    const ReconstructionOptions& options);

    TrackedFrame process(const types::RectifiedFrame& frame) override;
    void move_to(types::Track& track) override;

private:
    bool keep_if_due(const types::RectifiedFrame& frame,
                     const types::DepthMap& depth,
                     const odometry::Registration& vision);
    std::optional<FrameToMap> to_map(const types::RectifiedFrame& frame,
                                     types::DepthMap depth,
                                     const odometry::Registration& vision,
                                     bool kept);

    types::RectifiedRig rig_;
    ReconstructionOptions options_;
    stereo::StereoMatcher stereo_;
    features::FeatureTracker tracker_;
    imu::InertialPrior inertial_;
    odometry::MotionModel motion_;
    odometry::DynamicFeatures dynamic_features_;
    keyframes::KeyframeRule keyframe_rule_;
    keyframes::MappingRule mapping_rule_;
    types::Features features_;  // static ones, as the last frame had them
    std::vector<types::Keyframe> keyframes_;
    odometry::TrackSummary summary_;
};

// Tracks all frames of a recording by the method of the paper.
types::Track track_pairwise(types::Recording& recording,
                            const ReconstructionOptions& options,
                            const keyframes::KeyframeStore& store,
                            const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
