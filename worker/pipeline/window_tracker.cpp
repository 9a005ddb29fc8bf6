#include "worker/pipeline/window_tracker.hpp"

#include <utility>

#include "worker/features/match_sparse_stereo.hpp"
#include "worker/odometry/frame_features.hpp"
#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/odometry/register_with_rotation.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/stereo/disparity_search_range.hpp"

namespace divemesh::pipeline {

WindowTracker::WindowTracker(const types::RectifiedRig& rig,
                             const types::Recording& recording,
                             const ReconstructionOptions& options)
    : rig_(rig),
      options_(options),
      tracker_(rig, options.num_features),
      inertial_(recording, options),
      aligner_(recording),
      map_(rig, inertial_),
      memory_(rig, options.close_loops, options.num_disparities_px),
      mapping_rule_(rig, options.surface ? options.map_step : 0.0),
      motion_(rig, inertial_),
      moving_(rig) {}

TrackedFrame WindowTracker::process(const types::RectifiedFrame& frame) {
    const std::int64_t now_ns = frame.timestamp_ns;
    if (!motion_.started()) motion_.start(now_ns, odometry::first_pose(inertial_, rig_, now_ns));
    const std::int64_t before_ns = motion_.timestamp_ns();
    const auto rotation = motion_.rotation(now_ns);
    const auto expected = motion_.predict(rotation, now_ns);

    types::Features tracks =
        tracker_.track(frame.left, moving_.with_dynamic(features_), expected);      // 2
    features::match_sparse_stereo(frame, {}, options_.num_disparities_px, tracks);  // 1
    moving_.take_dynamic(tracks);
    const odometry::PointPairs measured =
        odometry::with_depth_at_both_times(rig_, features_, tracks);  // 3
    odometry::PointPairs pairs = measured;
    map_.use_landmarks(motion_.T_world_cam(), pairs);
    const auto vision = odometry::register_with_rotation(  // 4
        rig_,
        pairs,
        rotation,
        expected,
        odometry::kInlierTolerance_px,
        odometry::seed_of(options_.seed, frame));
    const auto guess = odometry::predict_orientation(rotation, vision);  // 5
    const auto T_current_previous =                                      // 6
        vision.found ? summary_.counted(odometry::refine_pose(rig_, vision.inliers, guess))
                     : expected;

    motion_.advance(T_current_previous, now_ns);
    if (options_.align_imu) aligner_.watch(rig_, measured, vision, before_ns, now_ns, inertial_);
    const bool first = map_.empty();
    first ? summary_.add_first_frame() : summary_.add_frame(tracks, vision, guess);
    moving_.classify(pairs, vision);
    features_ = odometry::without_dynamic_features(tracks, pairs, vision);
    odometry::add_lost_features(
        frame, T_current_previous, options_.num_disparities_px, tracker_, features_);
    const bool keep = first || (vision.found && map_.due(features_, now_ns));
    if (keep || !vision.found)
        odometry::add_new_features(
            rig_, frame, {}, options_.num_disparities_px, tracker_, features_);
    if (!vision.found) memory_.mark_lost();
    std::optional<features::DescribedKeypoints> view;
    if (keep) view = keep_keyframe(frame);
    TrackedFrame tracked{T_current_previous, motion_.T_world_cam(), moving_.before(), {}};
    tracked.by_vision = vision.found;
    tracked.features = odometry::feature_counts(features_);
    if (keep || (vision.found && mapping_rule_.due(features_))) {
        mapping_rule_.taken(features_);
        const types::DisparityRange range =
            stereo::disparity_search_range(features_, options_.num_disparities_px);  // 1
        tracked.to_map = {
            {}, {std::move(view), moving_.now(), odometry::static_features(vision), range}};
    }
    return tracked;
}

std::optional<features::DescribedKeypoints> WindowTracker::keep_keyframe(
    const types::RectifiedFrame& frame) {
    memory_.relocalise(frame, odometry::seed_of(options_.seed, frame), features_, motion_);
    map_.add(frame, features_, motion_, inertial_);
    return memory_.keep(frame, features_, motion_.T_world_cam());
}

void WindowTracker::move_to(types::Track& track) {
    track.statistics = summary_.statistics();
    track.imu_alignment = aligner_.alignment();
    map_.move_to(track);
}

types::Track track_window(types::Recording& recording,
                          const ReconstructionOptions& options,
                          const keyframes::KeyframeStore& store,
                          const base::ProgressCallback& progress) {
    const camera::Rectifier rectifier(recording.rig());
    WindowTracker tracker(rectifier.rig(), recording, options);
    return track_frames(recording, rectifier, options, store, tracker, progress);
}

}  // namespace divemesh::pipeline
