#include "worker/pipeline/window_tracker.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "worker/features/match_sparse_stereo.hpp"
#include "worker/odometry/frame_features.hpp"
#include "worker/odometry/motion_by_vision.hpp"
#include "worker/odometry/pair_inliers.hpp"
#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/odometry/register_with_rotation.hpp"
#include "worker/odometry/support.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/pipeline/sensor_findings.hpp"
#include "worker/stereo/disparity_search_range.hpp"

namespace divemesh::pipeline {
namespace {

// Attempts: as stated, by vision alone, with another clock offset or fewer sensors, and without the
// times in which a sensor contradicted the images.
constexpr int kMaxAttempts = 5;
constexpr double kMinDepth_m = 0.05;
constexpr int kNumPasses = 2;  // the first makes the motion more accurate for the second
// With fewer static features new ones are looked for at once.
constexpr std::size_t kFewFeatures = 60;
// A rig that turns faster than one degree a second does not rest, whatever the images show.
constexpr std::int64_t kTurnTime_ns = 500'000'000;
constexpr double kTurned_rad = 0.01;
constexpr std::int64_t kBiasTime_ns = 7'000'000'000;  // later the sliding window knows it as well

std::size_t num_with_depth(const types::Features& features) {
    return static_cast<std::size_t>(
        std::count_if(features.begin(), features.end(), types::has_depth));
}

}  // namespace

WindowTracker::WindowTracker(const types::RectifiedRig& rig,
                             const types::Recording& recording,
                             const ReconstructionOptions& options,
                             const imu::SensorPlan& plan)
    : rig_(rig),
      options_(options),
      tracker_(rig, options.num_features),
      inertial_(recording, options, plan.left_out),
      aligner_(recording, plan.left_out, plan.time_offset_s),
      sensors_(recording, options.use_imu && recording.rig().imu_noise, plan),
      map_(rig, inertial_),
      memory_(rig, options.close_loops, options.num_disparities_px),
      mapping_rule_(rig, options.surface ? options.map_step : 0.0),
      motion_(rig, inertial_),
      moving_(rig),
      scene_(rig),
      rest_(rig) {
    if (plan.time_offset_s != 0.0) inertial_.align({plan.time_offset_s});
}

TrackedFrame WindowTracker::process(const types::RectifiedFrame& frame) {
    const std::int64_t now_ns = frame.timestamp_ns;
    if (!motion_.started()) motion_.start(now_ns, odometry::first_pose(inertial_, rig_, now_ns));
    const std::int64_t before_ns = motion_.timestamp_ns();
    const auto rotation = motion_.rotation(now_ns);
    const auto expected = motion_.predict(rotation, now_ns);

    Observed seen =
        observe(frame,
                tracker_.track(frame.left, moving_.with_dynamic(features_), expected),  // 2
                rotation,
                expected);
    const bool dbg = std::getenv("TRK_DBG") != nullptr;
    const bool ok = odometry::well_supported(rig_, seen.vision, num_with_depth(features_), expected);
    if (dbg)
        std::fprintf(stderr,
                     "DBG %ld prev %zu pairs %zu inl %zu found %d exp_inl %zu ok %d dyn %zu",
                     static_cast<long>(frame.index),
                     num_with_depth(features_),
                     seen.pairs.size(),
                     seen.vision.inliers.size(),
                     seen.vision.found,
                     odometry::find_inliers(rig_, seen.pairs, expected, 2.0).size(),
                     ok,
                     moving_.now().size());
    if (!map_.empty() &&
        !odometry::well_supported(rig_, seen.vision, num_with_depth(features_), expected) &&
        !scene_.confirms(seen.vision, expected))
        seen = recover(frame, rotation, expected, std::move(seen));
    const odometry::Registration& vision = seen.vision;
    // At rest vision does not drift, but the gyroscope does.
    const auto guess = odometry::predict_orientation(  // 5
        rest_.hardly_moves() ? std::nullopt : rotation,
        vision);
    const auto estimated =                                               // 6
        vision.found ? summary_.counted(odometry::refine_pose(rig_, vision.inliers, guess))
                     : expected;
    const auto at_rest = watch_rest(vision, estimated, now_ns);
    const auto T_current_previous = at_rest.value_or(estimated);
    if (dbg)
        std::fprintf(stderr,
                     " | pairs %zu inl %zu found %d pred %d rest %d t %.4f\n",
                     seen.pairs.size(),
                     seen.vision.inliers.size(),
                     seen.vision.found,
                     seen.predicted,
                     at_rest.has_value(),
                     T_current_previous.translation().norm());

    scene_.update(seen.pairs, vision, motion_.T_world_cam(), before_ns, now_ns);
    motion_.advance(T_current_previous, now_ns);
    if (vision.found) motion_.confirm_by_vision();
    if (at_rest) rest(now_ns);
    watch_sensors(seen.measured, vision, before_ns, now_ns);
    const bool first = map_.empty();
    first ? summary_.add_first_frame() : summary_.add_frame(seen.tracks, vision, guess);
    // Outliers over a wide baseline are false matches: what moves by itself is too far away.
    if (seen.predicted) moving_.classify(seen.pairs, vision);
    features_ = odometry::without_dynamic_features(seen.tracks, seen.pairs, vision);
    odometry::add_lost_features(
        frame, T_current_previous, options_.num_disparities_px, scene_, tracker_, features_);
    // A rig that hardly moves sees nothing new, however much passes in front of it.
    const bool few = vision.inliers.size() < kFewFeatures;
    const bool keep =
        first || (vision.found && !rest_.hardly_moves() && map_.due(features_, now_ns));
    if (keep || !vision.found || few)
        odometry::add_new_features(
            rig_, frame, {}, options_.num_disparities_px, tracker_, features_);
    if (!vision.found)
        memory_.mark_lost();
    else if (scene_.known(vision.inliers).size() >= odometry::kMinInliers)
        memory_.mark_found();
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
    if (vision.found) memory_.confirm(scene_.known(vision.inliers), motion_.T_world_cam());
    memory_.pass(frame);
    return tracked;
}

WindowTracker::Observed WindowTracker::observe(const types::RectifiedFrame& frame,
                                               types::Features tracks,
                                               const std::optional<types::KnownRotation>& rotation,
                                               const Eigen::Isometry3d& expected) {
    Observed seen;
    seen.tracks = std::move(tracks);
    features::match_sparse_stereo(frame, {}, options_.num_disparities_px, seen.tracks);  // 1
    moving_.take_dynamic(seen.tracks);
    seen.measured = odometry::with_depth_at_both_times(rig_, features_, seen.tracks);  // 3
    seen.pairs = seen.measured;
    map_.use_landmarks(motion_.T_world_cam(), seen.pairs);
    seen.vision = register_pairs(frame, seen.pairs, rotation, expected);  // 4
    return seen;
}

odometry::Registration WindowTracker::register_pairs(
    const types::RectifiedFrame& frame,
    const odometry::PointPairs& pairs,
    const std::optional<types::KnownRotation>& rotation,
    const Eigen::Isometry3d& expected) const {
    const auto motion_of = [&](const odometry::PointPairs& voting) {
        return odometry::register_with_rotation(rig_,
                                                voting,
                                                rotation,
                                                expected,
                                                odometry::kInlierTolerance_px,
                                                odometry::seed_of(options_.seed, frame));
    };
    odometry::Registration vision = motion_of(pairs);
    if (!vision.found) return vision;
    if (scene_.contradicts(features_, pairs, vision)) {
        const odometry::Registration by_known = motion_of(scene_.known(pairs));
        vision = odometry::register_near(rig_,
                                         pairs,
                                         rotation,
                                         by_known.found ? by_known.T_current_previous : expected,
                                         odometry::kInlierTolerance_px);
        if (vision.found && scene_.contradicts(features_, pairs, vision)) vision.found = false;
    }
    if (vision.found && scene_.is_hidden_behind(vision, motion_.T_world_cam()))
        vision.found = false;
    return vision;
}

WindowTracker::Observed WindowTracker::recover(const types::RectifiedFrame& frame,
                                               const std::optional<types::KnownRotation>& rotation,
                                               const Eigen::Isometry3d& expected,
                                               Observed predicted) {
    const auto better = [](const Observed& a, const Observed& b) {
        return a.vision.found &&
               (!b.vision.found || a.vision.inliers.size() > b.vision.inliers.size());
    };
    const odometry::DynamicFeatures moving = moving_;
    if (auto followed = follow_wide(frame, {expected, rotation}))
        if (better(*followed, predicted)) return std::move(*followed);
    moving_ = moving;
    if (predicted.vision.found && odometry::explained_by_chance(rig_, predicted.vision, expected))
        predicted.vision.found = false;
    if (!predicted.vision.found)
        if (auto recognised = recognise(frame, rotation, expected)) return std::move(*recognised);
    return predicted;
}

std::optional<WindowTracker::Observed> WindowTracker::follow_wide(
    const types::RectifiedFrame& frame, const loops::MotionPrior& prior) {
    const auto rough =
        memory_.register_to_previous(frame, prior, odometry::seed_of(options_.seed, frame));
    if (!rough) return std::nullopt;
    moving_.forget();
    Observed seen;
    seen.vision.T_current_previous = *rough;
    for (int pass = 0; pass < kNumPasses; ++pass) {
        const Eigen::Isometry3d motion = seen.vision.T_current_previous;
        seen = observe(frame, tracker_.track_again(features_, motion), prior.rotation, motion);
        if (!seen.vision.found) return std::nullopt;
    }
    seen.predicted = false;
    return seen;
}

std::optional<WindowTracker::Observed> WindowTracker::recognise(
    const types::RectifiedFrame& frame,
    const std::optional<types::KnownRotation>& rotation,
    const Eigen::Isometry3d& expected) {
    auto known = memory_.recognise(frame,
                                   motion_.T_world_cam() * expected.inverse(),
                                   odometry::seed_of(options_.seed, frame));
    if (!known) return std::nullopt;
    // The previous pose becomes that from which the predicted motion leads here.
    const Eigen::Isometry3d T_world_previous = motion_.T_world_cam();
    motion_.correct(known->T_world_cam * expected);
    const Eigen::Isometry3d T_previous_keyframe =
        motion_.T_world_cam().inverse() * known->T_world_keyframe;
    const types::Features previous = std::exchange(features_, {});
    for (const types::Feature& feature : known->in_keyframe) {
        const Eigen::Vector3d p_previous = T_previous_keyframe * types::point_cam(rig_, feature);
        if (p_previous.z() <= kMinDepth_m) continue;
        const Eigen::Vector3d pixel = types::project_px(rig_, p_previous);
        features_.push_back({feature.id, pixel.head<2>(), pixel.z()});
    }
    const odometry::DynamicFeatures moving = moving_;
    moving_.forget();
    Observed seen = observe(frame, std::move(known->features), rotation, expected);
    seen.predicted = false;
    if (seen.vision.found) return seen;
    motion_.correct(T_world_previous);
    features_ = previous;
    moving_ = moving;
    return std::nullopt;
}

std::optional<features::DescribedKeypoints> WindowTracker::keep_keyframe(
    const types::RectifiedFrame& frame) {
    const Eigen::Isometry3d A = motion_.T_world_cam();
    memory_.relocalise(frame, odometry::seed_of(options_.seed, frame), features_, motion_);
    const Eigen::Isometry3d B = motion_.T_world_cam();
    map_.add(frame, features_, motion_, inertial_);
    const Eigen::Isometry3d C = motion_.T_world_cam();
    if (std::getenv("TRK_DBG") != nullptr)
        std::fprintf(stderr,
                     "KEY %ld reloc %.4f window %.4f known %zu of %zu\n",
                     static_cast<long>(frame.index),
                     (A.inverse() * B).translation().norm(),
                     (B.inverse() * C).translation().norm(),
                     std::size_t{0},
                     num_with_depth(features_));
    rest_.restart();
    return memory_.keep(frame, features_, motion_.T_world_cam());
}

std::optional<Eigen::Isometry3d> WindowTracker::watch_rest(const odometry::Registration& vision,
                                                           const Eigen::Isometry3d& estimated,
                                                           std::int64_t now_ns) {
    if (!vision.found) return std::nullopt;
    if (turns_by_gyroscope(now_ns)) {
        rest_.restart();
        return std::nullopt;
    }
    const auto T_world_rest = rest_.watch(
        now_ns, odometry::static_features(vision), motion_.T_world_cam() * estimated.inverse());
    if (!T_world_rest) return std::nullopt;
    return T_world_rest->inverse() * motion_.T_world_cam();
}

bool WindowTracker::turns_by_gyroscope(std::int64_t now_ns) const {
    const auto turned = inertial_.rotation(now_ns - kTurnTime_ns, now_ns);
    if (!turned) return false;
    const double angle_rad = Eigen::AngleAxisd(turned->q).angle();
    return angle_rad > kTurned_rad + 3.0 * turned->sigma_rad;
}

void WindowTracker::rest(std::int64_t now_ns) {
    motion_.rest();
    if (now_ns - rest_.began_ns() > kBiasTime_ns) return;
    const Eigen::Quaterniond q_imu_cam(rig_.T_imu_cam.linear());
    inertial_.learn_bias_at_rest(
        rest_.began_ns(), now_ns, q_imu_cam * rest_.q_anchor_cam() * q_imu_cam.conjugate());
}

void WindowTracker::watch_sensors(const odometry::PointPairs& measured,
                                  const odometry::Registration& vision,
                                  std::int64_t before_ns,
                                  std::int64_t now_ns) {
    if (map_.empty()) return;
    if (!vision.found) return sensors_.lost_scene();
    const auto motion = odometry::motion_by_vision(rig_, measured, vision, before_ns, now_ns);
    if (!motion) return;
    if (!map_.is_adjusted() && rest_.hardly_moves())
        inertial_.learn_bias(before_ns, now_ns, Eigen::Quaterniond(motion->T_from_to.linear()));
    if (options_.align_imu) aligner_.watch(*motion, inertial_);
    sensors_.watch(*motion, inertial_);
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
    // Another attempt starts with the first frame, but what was reported is not taken back.
    double reached = 0.0;
    const auto forward_progress = [&](Progress at) {
        reached = std::max(reached, at.fraction);
        at.fraction = reached;
        progress(at);
    };
    imu::SensorPlan plan;
    for (int attempt = 1;; ++attempt) {
        WindowTracker tracker(rectifier.rig(), recording, options, plan);
        types::Track track =
            track_frames(recording, rectifier, options, store, tracker, forward_progress);
        auto other = tracker.sensors().restart();
        if (!other) other = tracker.sensors().restart_at_end();
        if (!other) {
            plan = tracker.sensors().plan();
            track.left_out = plan.left_out;
            track.findings = sensor_findings(plan);
            return track;
        }
        plan = *other;
        if (attempt + 1 == kMaxAttempts) {
            plan.left_out.imu = true;  // then nothing asks for another attempt
            plan.imu_on_probation = false;
            plan.gyroscope.fault = imu::GyroscopeFault::None;
        }
        recording.rewind();
        store.clear();
    }
}

}  // namespace divemesh::pipeline
