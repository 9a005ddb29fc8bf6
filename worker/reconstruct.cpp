#include "worker/reconstruct.hpp"

#include <algorithm>
#include <utility>

#include "worker/background.hpp"
#include "worker/estimation/calibration_refinement.hpp"
#include "worker/estimation/expected_path_error.hpp"
#include "worker/estimation/follow_keyframes.hpp"
#include "worker/estimation/frame_covariances.hpp"
#include "worker/estimation/frame_features.hpp"
#include "worker/estimation/global_adjustment.hpp"
#include "worker/estimation/imu_aligner.hpp"
#include "worker/estimation/inertial_prior.hpp"
#include "worker/estimation/keyframe_map.hpp"
#include "worker/estimation/loops/close_loops.hpp"
#include "worker/estimation/loops/drift_bound.hpp"
#include "worker/estimation/loops/find_loops.hpp"
#include "worker/estimation/loops/pieces.hpp"
#include "worker/estimation/loops/scene_memory.hpp"
#include "worker/estimation/mapping_rule.hpp"
#include "worker/estimation/motion.hpp"
#include "worker/estimation/track_summary.hpp"
#include "worker/frames_ahead.hpp"
#include "worker/free_memory.hpp"
#include "worker/geometry/rectifier.hpp"
#include "worker/keyframe_writer.hpp"
#include "worker/steps/choose_range.hpp"
#include "worker/steps/extract_surface.hpp"
#include "worker/steps/match_features.hpp"
#include "worker/steps/match_stereo.hpp"
#include "worker/steps/predict_orientation.hpp"
#include "worker/steps/refine_pose.hpp"
#include "worker/steps/refine_pose_by_ceres.hpp"
#include "worker/steps/register_points.hpp"
#include "worker/steps/register_with_turn.hpp"
#include "worker/steps/track_features.hpp"
#include "worker/steps/with_depth_at_both_times.hpp"
#include "worker/tracking/moving_features.hpp"
#include "worker/views_ahead.hpp"

namespace divemesh::worker {
namespace {

// A pair agrees with a motion within this.
constexpr double kInlierTolerance_px = 2.0;
constexpr std::size_t kCloudStep = 6;  // of the mapped frames
// How far a camera sees, in median depths of the dive.
constexpr double kReach = 3.0;

void report(const ProgressCallback& progress, std::size_t num_done, const Recording& recording) {
    Progress at;
    at.frames_done = static_cast<std::int64_t>(num_done);
    at.num_frames = recording.num_frames();
    at.fraction = static_cast<double>(num_done) / std::max(1, recording.num_frames());
    progress(at);
}

}  // namespace

Track track(Recording& recording,
            const ReconstructionOptions& options,
            const KeyframeStore& store,
            const ProgressCallback& progress) {
    const Rectifier rectifier(recording.rig());
    const RectifiedRig& rig = rectifier.rig();
    // The paper; else depth is measured at the features alone.
    const bool pairwise = options.estimator == "pairwise";
    Workers workers(options.num_threads);
    FramesAhead frames(recording, rectifier, workers);
    KeyframeWriter writer(rig, options, store, workers);
    StereoMatcher stereo(rig, options);
    FeatureTracker tracker(rig, options);
    InertialPrior inertial(recording, options);
    ImuAligner aligner(recording);
    KeyframeMap map(rig, options, inertial);
    SceneMemory memory(rig, options);
    MappingRule mapping(rig, options.surface ? options.map_step : 0.0);
    Motion motion(rig, inertial);
    MovingFeatures moving(rig);
    Features features;
    TrackSummary summary;
    Eigen::Isometry3d T_start_cam = Eigen::Isometry3d::Identity();
    Track result;
    result.rig = rig;

    while (const auto next = frames.next()) {
        const RectifiedFrame& frame = *next;
        const std::int64_t now_ns = frame.timestamp_ns;
        if (!motion.started()) motion.start(now_ns, first_pose(inertial, rig, now_ns));
        const std::int64_t before_ns = motion.timestamp_ns();
        const auto turn = motion.turn(now_ns);
        const auto expected = motion.expect(turn, now_ns);

        const DepthMap depth = pairwise ? stereo.match(frame) : DepthMap{};             // 1
        Features tracks = tracker.track(frame.left, moving.among(features), expected);  // 2
        match_features(frame, depth.disparity_px, options.num_disparities_px, tracks);  // 1
        moving.take_from(tracks);
        const PointPairs measured = with_depth_at_both_times(rig, features, tracks);  // 3
        PointPairs pairs = measured;
        map.use_landmarks(motion.T_world_cam(), pairs);
        const auto seed = seed_of(options, frame);
        const auto vision =  // 4
            pairwise ? register_points(rig, pairs, kInlierTolerance_px, seed)
                     : register_with_turn(rig, pairs, turn, expected, kInlierTolerance_px, seed);
        const auto guess = predict_orientation(turn, vision);  // 5
        const Eigen::Isometry3d T_current_previous =           // 6
            !vision.found ? expected
            : pairwise    ? refine_pose_by_ceres(rig, vision.inliers, guess)
                          : refine_pose(rig, vision.inliers, guess);
        motion.advance(T_current_previous, now_ns);
        T_start_cam = T_start_cam * T_current_previous.inverse();
        if (pairwise)
            learn_bias(inertial, rig, vision, before_ns, now_ns);
        else if (options.align_imu)
            aligner.watch(rig, measured, vision, before_ns, now_ns, inertial);

        if (map.empty())
            summary.add_first_frame();
        else
            summary.add_frame(tracks, vision, guess);
        moving.judge(pairs, vision);
        writer.go_on(moving.before());
        features = consistent(tracks, pairs, vision);
        if (!pairwise)
            add_lost_features(
                frame, T_current_previous, options.num_disparities_px, tracker, features);
        const bool keep = map.empty() || (vision.found && map.due(features, now_ns));
        if (keep || !vision.found)
            add_new_features(rig, frame, depth, options.num_disparities_px, tracker, features);
        if (!vision.found) memory.lose_sight();
        std::optional<DescribedView> view;
        if (keep) {
            memory.recognise(frame, seed, features, motion);
            map.add(frame, features, motion, inertial);
            view = memory.keep(frame, features, motion.T_world_cam());
        }
        if (keep || (vision.found && mapping.due(features))) {
            mapping.taken(features);
            const DisparityRange range = choose_range(features, options.num_disparities_px);  // 1
            writer.write(frame, depth, {std::move(view), moving.now(), gone_along(vision), range});
            result.mapped.push_back({frame.index, now_ns, motion.T_world_cam()});
        }
        result.causal.push_back({now_ns, motion.T_world_cam() * rig.T_imu_cam.inverse()});
        result.odometry.push_back({now_ns, T_start_cam * rig.T_imu_cam.inverse()});
        report(progress, result.causal.size(), recording);
    }
    writer.finish();
    map.move_to(result);
    result.imu_alignment = aligner.alignment();
    result.statistics = summary.statistics(recording.num_skipped_frames());
    result.statistics.dense = writer.statistics();
    return result;
}

OptimisedTrack optimise(const Track& track,
                        const Recording& recording,
                        const ReconstructionOptions& options,
                        const KeyframeStore& store,
                        const ProgressCallback& progress) {
    OptimisedTrack result;
    if (!options.adjust_whole_dive || options.estimator == "pairwise" ||
        track.keyframes.size() < 2) {  // the paper stops here
        result.trajectory = track.causal;
        result.keyframes = track.keyframes;
        result.mapped = track.mapped;
        result.rig = track.rig;
        return result;
    }
    InertialPrior inertial(recording, options);
    Progress at;
    at.fraction = 0.1;
    const DriftBound drift(track.keyframes, track.landmarks, &inertial);
    FoundLoops found;
    if (options.close_loops)
        found = find_loops(track, drift, store, static_cast<std::uint64_t>(options.seed), progress);
    result.statistics.loops = found.statistics;
    return_freed_memory();
    Track closed;  // what changes from here on
    closed.rig = track.rig;
    closed.odometry = track.odometry;
    closed.keyframes = track.keyframes;
    closed.landmarks = track.landmarks;
    closed.imu_alignment = track.imu_alignment;
    close_loops(closed.rig, found.loops, drift, closed.keyframes, closed.landmarks);
    at.fraction = 0.4;
    result.calibration = refine_calibration(closed, recording, options, inertial, progress, at);
    inertial.align({result.calibration.applied_alignment().time_offset_s});
    apply_calibration(recording.rig(), result.calibration, closed);
    return_freed_memory();
    at.fraction = 0.6;
    const AdjustedDive adjusted =
        adjust_dive(closed.rig, inertial, closed.keyframes, closed.landmarks, progress, at);
    result.statistics.reprojection_rms_px = adjusted.reprojection_rms_px;
    lay_apart(kReach * track.statistics.median_depth_m, closed.keyframes);
    result.trajectory = follow_keyframes(closed.odometry, closed.keyframes, closed.rig.T_imu_cam);
    result.covariances = covariances_at(
        adjusted.covariances, closed.odometry, closed.keyframes, closed.rig.T_imu_cam);
    result.statistics.path =
        with_frames_between(adjusted.path, adjusted.covariances, result.covariances);
    add_residuals(found.loops, closed.keyframes, result.statistics.loops);
    result.mapped =
        posed_by(result.trajectory, closed.keyframes, closed.rig.T_imu_cam, track.mapped);
    result.keyframes = std::move(closed.keyframes);
    result.rig = closed.rig;
    return result;
}

FusedMap fuse(const RectifiedRig& rig,
              const std::vector<Keyframe>& frames,
              double median_depth_m,
              const ReconstructionOptions& options,
              const KeyframeStore& store,
              const std::filesystem::path& scratch,
              const ProgressCallback& progress) {
    FusedMap map;
    map.volume = make_volume(rig, options, median_depth_m, scratch);
    map.cloud = make_cloud(map.volume->settings(), options);
    // Frames that follow one another see nearly the same points: all of them only where the points
    // are to be closer than a voxel needs.
    const std::size_t cloud_step =
        map.cloud->voxel_m() < 0.5 * map.volume->voxel_m() ? 1 : kCloudStep;
    Progress done;
    done.stage = "fuse";
    done.num_frames = static_cast<std::int64_t>(frames.size());
    Workers workers(options.num_threads);
    ViewsAhead views(rig, map.volume->voxel_m(), frames, store, workers);
    Background cloud(workers);  // ends before the map goes, also when progress() throws
    for (std::size_t i = 0; i < frames.size(); ++i) {
        progress(done);
        const auto depth = views.next();
        if (i % cloud_step == 0)
            cloud.run([&, i, depth] { map.cloud->add(frames[i], *depth); });  // 7
        map.volume->add(frames[i], *depth);                                   // 7
        ++done.frames_done;
        done.fraction =
            static_cast<double>(done.frames_done) / static_cast<double>(done.num_frames);
    }
    cloud.wait();
    progress(done);
    return map;
}

Mesh mesh(const Volume& volume,
          const ReconstructionOptions& options,
          const ProgressCallback& progress) {
    return extract_surface(volume, options, progress);  // 8
}

}  // namespace divemesh::worker
