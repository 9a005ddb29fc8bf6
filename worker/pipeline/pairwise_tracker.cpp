#include "worker/pipeline/pairwise_tracker.hpp"

#include <utility>

#include "worker/base/seconds.hpp"
#include "worker/camera/synchronise_pair.hpp"
#include "worker/features/match_sparse_stereo.hpp"
#include "worker/odometry/frame_features.hpp"
#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/odometry/sigma_of_motion.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/optimisation/refine_pose_by_ceres.hpp"

namespace divemesh::pipeline {

PairwiseTracker::PairwiseTracker(const types::RectifiedRig& rig,
                                 const types::Recording& recording,
                                 const ReconstructionOptions& options)
    : rig_(rig),
      options_(options),
      stereo_(options.stereo, options.num_disparities_px, options.stereo_scales),
      tracker_(rig, options.num_features),
      inertial_(recording, options),
      motion_(rig, inertial_),
      dynamic_features_(rig),
      keyframe_rule_(rig),
      mapping_rule_(rig, options.surface ? options.map_step : 0.0) {
    inertial_.let_ahrs_lead();
}

// Steps 7 and 8 are fuse() and mesh(), after all poses are known.
TrackedFrame PairwiseTracker::process(const types::RectifiedFrame& frame) {
    const std::int64_t now_ns = frame.timestamp_ns;
    if (!motion_.started()) motion_.start(now_ns, odometry::first_pose(inertial_, rig_, now_ns));
    const std::int64_t before_ns = motion_.timestamp_ns();
    const auto rotation = motion_.rotation(now_ns);
    const auto expected = motion_.predict(rotation, now_ns);

    types::DepthMap depth = stereo_.match(frame);  // 1
    types::Features tracks =
        tracker_.track(frame.left, dynamic_features_.with_dynamic(features_), expected);  // 2
    features::match_sparse_stereo(frame, depth.disparity_px, options_.num_disparities_px, tracks);
    dynamic_features_.take_dynamic(tracks);
    const odometry::PointPairs pairs =
        odometry::with_depth_at_both_times(rig_, features_, tracks);  // 3
    const auto vision =                                               // 4
        odometry::register_points(
            rig_, pairs, odometry::kInlierTolerance_px, odometry::seed_of(options_.seed, frame));
    const auto guess = odometry::predict_orientation(rotation, vision);  // 5
    const auto T_current_previous =                                      // 6
        vision.found
            ? summary_.counted(optimisation::refine_pose_by_ceres(rig_, vision.inliers, guess))
            : expected;

    motion_.advance(T_current_previous, now_ns);
    if (vision.found) motion_.confirm_by_vision();
    odometry::learn_bias(inertial_, rig_, vision, before_ns, now_ns);
    keyframes_.empty() ? summary_.add_first_frame() : summary_.add_frame(tracks, vision, guess);
    dynamic_features_.classify(pairs, vision);
    features_ = odometry::without_dynamic_features(tracks, pairs, vision);
    const bool kept = keep_if_due(frame, depth, vision);
    TrackedFrame tracked{T_current_previous, motion_.T_world_cam(), dynamic_features_.before(), {}};
    tracked.sigma = odometry::sigma_of_motion(
        rig_, vision, {T_current_previous, guess.rotation, 0.0}, base::to_s(now_ns - before_ns));
    tracked.by_vision = vision.found;
    tracked.features = odometry::feature_counts(features_);
    tracked.to_map = to_map(frame, std::move(depth), vision, kept);
    return tracked;
}

// Makes a keyframe of the frame if one is due, and adds new features to it. Returns true if it did.
bool PairwiseTracker::keep_if_due(const types::RectifiedFrame& frame,
                                  const types::DepthMap& depth,
                                  const odometry::Registration& vision) {
    const std::int64_t now_ns = frame.timestamp_ns;
    const bool keep = keyframes_.empty() || (vision.found && keyframe_rule_.due(features_, now_ns));
    if (keep || !vision.found)
        odometry::add_new_features(
            rig_, frame, depth, options_.num_disparities_px, tracker_, features_);
    if (!keep) return false;
    keyframe_rule_.taken(features_, now_ns);
    keyframes_.push_back({frame.index, now_ns, motion_.T_world_cam()});
    return true;
}

// Returns the frame for the map if it is a keyframe or the image has moved far enough.
std::optional<FrameToMap> PairwiseTracker::to_map(const types::RectifiedFrame& frame,
                                                  types::DepthMap depth,
                                                  const odometry::Registration& vision,
                                                  bool kept) {
    const keyframes::MappingView view{
        features_, motion_.T_world_cam().translation(), odometry::median_disparity_px(features_)};
    if (!kept && !(vision.found && mapping_rule_.due(view))) return std::nullopt;
    mapping_rule_.taken(view);
    camera::correct_disparities(frame, depth);
    return FrameToMap{frame,
                      std::move(depth),
                      {{}, dynamic_features_.now(), odometry::static_features(vision), {}}};
}

void PairwiseTracker::move_to(types::Track& track) {
    track.keyframes = std::move(keyframes_);
    track.statistics = summary_.statistics();
}

types::Track track_pairwise(types::Recording& recording,
                            const ReconstructionOptions& options,
                            const keyframes::KeyframeStore& store,
                            const base::ProgressCallback& progress) {
    const camera::Rectifier rectifier(recording, options.num_threads);
    PairwiseTracker tracker(rectifier.rig(), recording, options);
    return track_frames(recording, rectifier, options, store, tracker, progress);
}

}  // namespace divemesh::pipeline
