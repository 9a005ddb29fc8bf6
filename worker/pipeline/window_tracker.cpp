#include "worker/pipeline/window_tracker.hpp"

#include <algorithm>
#include <utility>

#include "worker/base/seconds.hpp"
#include "worker/camera/synchronise_pair.hpp"
#include "worker/imu/usable_samples.hpp"
#include "worker/odometry/frame_features.hpp"
#include "worker/odometry/motion_by_vision.hpp"
#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/odometry/sigma_of_motion.hpp"
#include "worker/odometry/support.hpp"
#include "worker/pipeline/motion_between_exposures.hpp"
#include "worker/pipeline/sensor_attempts.hpp"
#include "worker/pipeline/sensor_findings.hpp"
#include "worker/stereo/disparity_search_range.hpp"

namespace divemesh::pipeline {
namespace {

// A rig that hardly moves looks for new features at once if it has fewer.
constexpr std::size_t kMinFeaturesAtRest = 60;

// Returns what the IMU says of the motion that vision found: all of it from a known velocity on, or
// else its rotation.
Eigen::Isometry3d motion_by_imu(const PredictedMotion& prediction,
                                const Eigen::Isometry3d& T_by_vision) {
    if (prediction.imu_alone_s) return prediction.T_current_previous;
    Eigen::Isometry3d T_current_previous = T_by_vision;
    T_current_previous.linear() = prediction.rotation->q.toRotationMatrix();
    return T_current_previous;
}

}  // namespace

WindowTracker::WindowTracker(const types::RectifiedRig& rig,
                             const types::Recording& recording,
                             const ReconstructionOptions& options,
                             const imu::SensorPlan& plan)
    : state_(rig, recording, options, plan),
      recovery_(state_),
      rest_(rig, state_.inertial, state_.motion),
      imu_check_(rig, state_.inertial.noise()),
      aligner_(recording, plan.left_out, plan.alignment, plan.num_alignment_rotations),
      sensors_(recording,
               {.imu = options.use_imu && recording.rig().imu_noise, .ahrs = options.use_ahrs},
               plan),
      mapping_rule_(rig, options.surface ? options.map_step : 0.0),
      last_frame_(recording.num_frames() - 1) {
    if (plan.alignment.time_offset_s != 0.0) state_.inertial.align(plan.alignment);
}

types::RectifiedFrame WindowTracker::synchronised(const types::RectifiedFrame& frame,
                                                  const PredictedMotion& prediction) const {
    const std::int64_t interval_ns = frame.timestamp_ns - state_.motion.timestamp_ns();
    if (!prediction.reliable || interval_ns <= 0) return frame;
    const double share = frame.right_delay_s / base::to_s(interval_ns);
    return camera::synchronise_pair(
        frame,
        motion_between_exposures(
            state_.rig, prediction.T_current_previous, share, state_.features));
}

TrackedFrame WindowTracker::process(const types::RectifiedFrame& recorded) {
    odometry::MotionModel& motion = state_.motion;
    const std::int64_t now_ns = recorded.timestamp_ns;
    if (!motion.started())
        motion.start(now_ns, odometry::first_pose(state_.inertial, state_.rig, now_ns));
    const std::int64_t before_ns = motion.timestamp_ns();
    const auto rotation = motion.rotation(now_ns);
    const PredictedMotion prediction{rotation,
                                     motion.predict(rotation, now_ns),
                                     motion.predicts_reliably(now_ns),
                                     motion.imu_alone_s(now_ns)};
    const types::RectifiedFrame frame = synchronised(recorded, prediction);

    const Observed seen = observe(frame, prediction);  // 2, 3, 4
    const odometry::Registration& vision = seen.vision;
    const bool imu_fits = check_imu(seen, prediction, {before_ns, now_ns});
    // At rest the pose by vision does not drift; by the gyroscope it would.
    const auto guess = odometry::predict_orientation(  // 5
        rest_.hardly_moves() || !imu_fits ? std::nullopt : rotation,
        vision);
    const auto estimated =  // 6
        vision.found ? summary_.counted(odometry::refine_pose(state_.rig, vision.inliers, guess))
                     : prediction.T_current_previous;
    const auto at_rest = rest_.watch(vision, seen.tracks, estimated, now_ns);
    const auto T_current_previous = at_rest.value_or(estimated);

    state_.scene.update(seen.pairs, vision, motion.T_world_cam(), before_ns, now_ns);
    motion.advance(T_current_previous, now_ns);
    if (vision.found) motion.confirm_by_vision();
    if (at_rest) rest_.settle(now_ns);
    watch_sensors(seen, before_ns, now_ns);
    state_.map.empty() ? summary_.add_first_frame()
                       : summary_.add_frame(seen.tracks, vision, guess);
    choose_features(frame, seen, T_current_previous);
    const bool kept = keep_if_due(frame, vision);
    TrackedFrame tracked{
        T_current_previous, motion.T_world_cam(), state_.dynamic_features.before(), {}};
    const odometry::Registration not_measured;
    tracked.sigma = odometry::sigma_of_motion(state_.rig,
                                              seen.recognised ? not_measured : vision,
                                              {T_current_previous, guess.rotation, 0.0},
                                              base::to_s(now_ns - before_ns));
    tracked.by_vision = vision.found;
    tracked.predicted_by_imu = prediction.imu_alone_s.has_value();
    tracked.features = odometry::feature_counts(state_.features);
    tracked.to_map = to_map(frame, vision, kept);
    state_.memory.pass(frame);
    return tracked;
}

Observed WindowTracker::observe(const types::RectifiedFrame& frame,
                                const PredictedMotion& prediction) {
    const std::optional<Eigen::Isometry3d> expected = prediction.expected();
    Observed seen =
        observe_frame(state_,
                      frame,
                      state_.tracker.track(frame.left,
                                           state_.dynamic_features.with_dynamic(state_.features),
                                           prediction.T_current_previous),
                      prediction);
    const std::size_t num_previous = odometry::num_with_depth(state_.features);
    if (state_.map.empty() ||
        odometry::well_supported(state_.rig, seen.vision, num_previous, expected) ||
        (state_.scene.confirms(seen.vision, expected) &&
         !odometry::explained_by_chance(state_.rig, seen.vision, num_previous, expected)))
        return seen;
    if (auto without_imu = observe_without_imu(frame, prediction)) return std::move(*without_imu);
    return recovery_.recover(frame, prediction, std::move(seen));
}

std::optional<Observed> WindowTracker::observe_without_imu(const types::RectifiedFrame& frame,
                                                           const PredictedMotion& prediction) {
    if (!prediction.rotation || !prediction.reliable || !state_.inertial.has_gyroscope())
        return std::nullopt;
    const odometry::DynamicFeatures dynamic_features = state_.dynamic_features;
    const PredictedMotion steady{std::nullopt, state_.motion.predict_steadily(frame.timestamp_ns)};
    const types::Features previous = state_.dynamic_features.with_dynamic(state_.features);
    Observed seen = observe_frame(
        state_, frame, state_.tracker.track_again(previous, steady.T_current_previous), steady);
    if (odometry::well_supported(
            state_.rig, seen.vision, odometry::num_with_depth(state_.features), std::nullopt)) {
        seen.against_imu = odometry::is_elsewhere(
            state_.rig, seen.vision, motion_by_imu(prediction, seen.vision.T_current_previous));
        return seen;
    }
    state_.dynamic_features = dynamic_features;
    return std::nullopt;
}

bool WindowTracker::check_imu(const Observed& seen,
                              const PredictedMotion& prediction,
                              const types::TimeInterval& time) {
    // Without a gyroscope the rotation is that of the AHRS, which SensorWatch judges.
    if (!prediction.rotation || !state_.inertial.has_gyroscope() || seen.recognised) return true;
    if (rest_.confirmed_by_imu(seen.vision, time.to_ns)) return true;
    const bool contradicted =
        imu_check_.contradicts(seen.vision, *prediction.rotation, time) || seen.against_imu ||
        (prediction.imu_alone_s && !rest_.rested_lately(time.to_ns) &&
         imu_check_.contradicts(
             seen.vision, prediction.T_current_previous, *prediction.imu_alone_s, time));
    if (!contradicted) return true;
    state_.inertial.leave_out(time);
    sensors_.contradicted_in(time);
    return false;
}

void WindowTracker::watch_sensors(const Observed& seen,
                                  std::int64_t before_ns,
                                  std::int64_t now_ns) {
    if (state_.map.empty()) return;
    if (rest_.confirmed_by_imu(seen.vision, now_ns)) {
        if (!state_.map.is_adjusted())
            state_.inertial.learn_bias(before_ns, now_ns, Eigen::Quaterniond::Identity());
        return sensors_.passed_frame();
    }
    if (!seen.vision.found) return sensors_.lost_scene();
    if (seen.recognised) return;
    const auto motion =
        odometry::motion_by_vision(state_.rig, seen.measured, seen.vision, before_ns, now_ns);
    if (!motion) return;
    if (!state_.map.is_adjusted() && rest_.hardly_moves())
        state_.inertial.learn_bias(
            before_ns, now_ns, Eigen::Quaterniond(motion->T_from_to.linear()));
    if (state_.options.align_imu) {
        aligner_.watch(*motion, state_.inertial);
        sensors_.aligned(aligner_.alignment(), aligner_.num_rotations());
    }
    sensors_.watch(*motion, state_.inertial);
}

void WindowTracker::choose_features(const types::RectifiedFrame& frame,
                                    const Observed& seen,
                                    const Eigen::Isometry3d& T_current_previous) {
    // Outliers over a wide baseline are false matches: what moves by itself is too far away.
    if (seen.predicted) state_.dynamic_features.classify(seen.pairs, seen.vision);
    state_.features = odometry::without_dynamic_features(seen.tracks, seen.pairs, seen.vision);
    odometry::add_lost_features(frame,
                                T_current_previous,
                                state_.options.num_disparities_px,
                                state_.scene,
                                state_.tracker,
                                state_.features);
}

bool WindowTracker::note_sight(const odometry::Registration& vision,
                               const odometry::PointPairs& known) {
    if (!vision.found) {
        state_.memory.mark_lost();
        if (!state_.map.empty() && !ever_found_) lost_from_start_ = true;
        return false;
    }
    ever_found_ = true;
    if (known.size() >= odometry::kMinInliers) state_.memory.mark_found();
    return std::exchange(lost_from_start_, false);
}

bool WindowTracker::keep_if_due(const types::RectifiedFrame& frame,
                                const odometry::Registration& vision) {
    loops::Relocaliser& memory = state_.memory;
    const odometry::PointPairs known = state_.scene.known(vision.inliers);
    const bool begins = note_sight(vision, known);
    // A rig that hardly moves sees nothing new, however much passes in front of it.
    const bool rests = rest_.hardly_moves();
    const auto is_due = [&] {
        return rests ? state_.map.due_at_rest(state_.features, rest_.resting_since())
                     : state_.map.due(state_.features, frame.timestamp_ns);
    };
    // The covariance of a path takes two keyframes.
    const bool ends_with_one = frame.index == last_frame_ && !state_.map.is_adjusted() && !rests;
    const bool keep = state_.map.empty() || begins || (vision.found && (ends_with_one || is_due()));
    if (keep || !vision.found || (rests && vision.inliers.size() < kMinFeaturesAtRest))
        odometry::add_new_features(state_.rig,
                                   frame,
                                   {},
                                   state_.options.num_disparities_px,
                                   state_.tracker,
                                   state_.features);
    // Nothing but an unknown velocity ties the scene to a first keyframe in the dark.
    if (begins) state_.map = KeyframeMap(state_.rig, state_.inertial);
    view_.reset();
    if (keep) {
        const bool recognised = memory.relocalise(
            frame, odometry::seed_of(state_.options.seed, frame), state_.features, state_.motion);
        state_.map.add(frame,
                       state_.features,
                       recognised ? std::vector<types::Rest>{} : rest_.rests(),
                       state_.motion,
                       state_.inertial);
        rest_.correct();
        view_ = memory.keep(frame, state_.features, state_.motion.T_world_cam());
    }
    if (vision.found) memory.confirm(known, state_.motion.T_world_cam());
    return keep;
}

std::optional<FrameToMap> WindowTracker::to_map(const types::RectifiedFrame& frame,
                                                const odometry::Registration& vision,
                                                bool kept) {
    const keyframes::MappingView view{state_.features,
                                      state_.motion.T_world_cam().translation(),
                                      odometry::median_disparity_px(state_.features)};
    if (!kept && !(vision.found && mapping_rule_.due(view))) return std::nullopt;
    mapping_rule_.taken(view);
    const types::DisparityRange range = stereo::disparity_search_range(  // 1
        state_.features,
        state_.options.num_disparities_px,
        state_.rig.width_px);
    return FrameToMap{frame,
                      {},
                      {std::move(view_),
                       state_.dynamic_features.now(),
                       odometry::static_features(vision),
                       range}};
}

void WindowTracker::move_to(types::Track& track) {
    track.statistics = summary_.statistics();
    track.imu_alignment = aligner_.alignment();
    track.rests = rest_.rests();
    state_.map.move_to(track);
}

types::Track track_window(types::Recording& recording,
                          const ReconstructionOptions& options,
                          const keyframes::KeyframeStore& store,
                          const base::ProgressCallback& progress) {
    const camera::Rectifier rectifier(recording, options.num_threads);
    // Another attempt starts with the first frame, but what was reported is not taken back.
    double reached = 0.0;
    const auto forward_progress = [&](Progress at) {
        reached = std::max(reached, at.fraction);
        at.fraction = reached;
        progress(at);
    };
    for (SensorAttempts attempts(recording);;) {
        WindowTracker tracker(rectifier.rig(), recording, options, attempts.plan());
        types::Track track =
            track_frames(recording, rectifier, options, store, tracker, forward_progress);
        if (!attempts.again(tracker.sensors(), track)) {
            track.left_out = attempts.plan().left_out;
            track.findings = sensor_findings(attempts.plan());
            if (const auto& stated = recording.rig().imu_noise; stated && options.use_imu)
                if (auto noisy = imu_noisy(imu::usable_rates(recording, track.left_out),
                                           *stated,
                                           !track.left_out.accelerometer))
                    track.findings.push_back(std::move(*noisy));
            return track;
        }
        recording.rewind();
        store.clear();
    }
}

}  // namespace divemesh::pipeline
