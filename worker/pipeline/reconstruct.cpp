#include "worker/pipeline/reconstruct.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/background_task.hpp"
#include "worker/fusion/voxel_size.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/loops/drift_model.hpp"
#include "worker/loops/motions_in_sight.hpp"
#include "worker/mesh/extract_surface.hpp"
#include "worker/pipeline/depth_across_frames.hpp"
#include "worker/pipeline/depth_view_prefetcher.hpp"
#include "worker/pipeline/estimators.hpp"
#include "worker/pipeline/measured_poses.hpp"
#include "worker/pipeline/optimise_track.hpp"
#include "worker/pipeline/sensor_findings.hpp"
#include "worker/pipeline/solver_findings.hpp"
#include "worker/pipeline/track_agreement.hpp"
#include "worker/pipeline/tracking_findings.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::size_t kCloudStep = 6;   // every n-th mapped frame
constexpr int kPlannedColumns = 80;     // of a frame's depth map by which levels are planned
constexpr int kMaxPlannedStep_px = 12;  // about half a block as the frame sees it

types::OptimisedTrack as_tracked(const types::Track& track) {
    types::OptimisedTrack result;
    result.trajectory = track.causal;
    result.breaks_ns = track.breaks_ns;
    result.keyframes = track.keyframes;
    result.mapped = track.mapped;
    result.rig = track.rig;
    result.calibration.tracked_time_offset_s = track.imu_alignment.time_offset_s;
    return result;
}

// Checks a track that nothing adjusts against its own observations.
void check_as_tracked(const types::Track& track,
                      const types::Recording& recording,
                      const ReconstructionOptions& options,
                      types::OptimisedTrack& result) {
    const imu::InertialPrior inertial(recording, options, track.left_out);
    const loops::DriftModel drift(
        track.keyframes, track.landmarks, &inertial, loops::motions_in_sight(track));
    result.statistics.check.before = agreement(track, track, 1, drift);
    result.statistics.check.after = result.statistics.check.before;
}

// Compares the pressure sensor with the path.
imu::PressureJudgement judge_pressure(const types::Recording& recording,
                                      const ReconstructionOptions& options,
                                      const types::Track& track) {
    if (!options.use_pressure) return {};
    const imu::InertialPrior inertial(recording, options, track.left_out);
    const bool vertical_is_known =
        !track.causal.empty() && inertial.knows_vertical(track.causal.front().timestamp_ns);
    return imu::judge_pressure(
        recording.pressure(), track.causal, track.breaks_ns, vertical_is_known);
}

types::Track tracked(types::Recording& recording,
                     const ReconstructionOptions& options,
                     const keyframes::KeyframeStore& store,
                     const base::ProgressCallback& progress) {
    types::Track result = estimator_of(options).track(recording, options, store, progress);
    bridge_by_imu(imu::InertialPrior(recording, options, result.left_out), result);
    result.breaks_ns = breaks_of(result);
    drop_unmeasured_keyframes(result);
    return result;
}

// Returns the median depth of the tracked features, or without any that of the first frame's
// surface: a single frame tracks nothing.
double median_depth_m(const FramesToFuse& input) {
    if (input.median_depth_m > 0.0 || input.frames.empty()) return input.median_depth_m;
    const types::KeyframeImages images = input.store.read(input.frames.front().frame_index);
    const float disparity_px = fusion::median_disparity_px(images.depth);
    return disparity_px > 0.0F ? input.rig.depth_m(disparity_px) : 0.0;
}

// Levels are planned unless the user fixed the voxel. The paper's octree and marching cubes know
// one size.
fusion::VolumeSettings settings_of_volume(const FramesToFuse& input,
                                          const ReconstructionOptions& options,
                                          double median_m,
                                          const std::filesystem::path& scratch) {
    fusion::VolumeSettings settings =
        fusion::choose_settings(input.rig, options, median_m, scratch);
    if (options.voxel_m > 0.0 || options.fusion != "tsdf" || options.mesher != "surface_nets")
        return settings;
    fusion::LevelPlanner planner(input.rig, settings.voxel_m, median_m);
    const int step_px = std::clamp(input.rig.width_px / kPlannedColumns, 1, kMaxPlannedStep_px);
    for (const types::Keyframe& frame : input.frames)
        planner.add(
            frame.T_world_cam, input.store.read_disparities(frame.frame_index, step_px), step_px);
    fusion::LevelPlanner::Planned planned = planner.finish();
    settings.voxel_m = planned.voxel_m;
    settings.levels = std::make_shared<fusion::LevelPlan>(std::move(planned.plan));
    if (options.max_depth_m <= 0.0)
        settings.max_depth_m = fusion::choose_max_depth_m(
            input.rig, std::ldexp(settings.voxel_m, settings.levels->num_levels() - 1));
    return settings;
}

}  // namespace

types::Track track(types::Recording& recording,
                   const ReconstructionOptions& options,
                   const keyframes::KeyframeStore& store,
                   const base::ProgressCallback& progress) {
    types::Track result = tracked(recording, options, store, progress);
    const imu::PressureJudgement judgement = judge_pressure(recording, options, result);
    result.pressure_error_m = judgement.error_m;
    if (judgement.fault == imu::PressureFault::None) return result;
    // The path must not keep what a wrong sensor did to it.
    ReconstructionOptions without_pressure = options;
    without_pressure.use_pressure = false;
    store.clear();
    result = {};
    result = tracked(recording, without_pressure, store, progress);
    result.left_out.pressure = true;
    result.findings.push_back(pressure_left_out(judgement));
    return result;
}

types::OptimisedTrack optimise(const types::Track& track,
                               const types::Recording& recording,
                               const ReconstructionOptions& options,
                               const keyframes::KeyframeStore& store,
                               const types::RigAlignment& alignment,
                               const base::ProgressCallback& progress,
                               optimisation::WithPrior with_prior) {
    const auto untracked = too_little_tracked(track);
    const bool whole_dive = !untracked && options.adjust_whole_dive &&
                            estimator_of(options).adjusts_whole_dive && track.keyframes.size() >= 2;
    types::OptimisedTrack result =
        whole_dive
            ? optimise_track(track, recording, options, store, alignment, progress, with_prior)
            : as_tracked(track);
    if (!whole_dive && !untracked) check_as_tracked(track, recording, options, result);
    std::vector<Finding> findings = track.findings;
    const auto lost = tracking_findings(track);
    findings.insert(findings.end(), lost.begin(), lost.end());
    const auto of_solvers = window_findings(track.statistics);
    findings.insert(findings.end(), of_solvers.begin(), of_solvers.end());
    if (untracked) {
        findings.insert(findings.begin(), *untracked);
    } else if (const auto finding = divergence(track, result)) {
        findings.insert(findings.begin(), *finding);
        findings.insert(findings.end(), result.findings.begin(), result.findings.end());
        const types::OptimiseStatistics ended = result.statistics;
        result = as_tracked(track);
        result.statistics.pose_graph = ended.pose_graph;
        result.statistics.calibration = ended.calibration;
        result.statistics.bundle_adjustment = ended.bundle_adjustment;
        result.statistics.check = ended.check;
    }
    result.findings.insert(result.findings.begin(), findings.begin(), findings.end());
    set_predicted_apart(result);
    return result;
}

FusedMap fuse(const FramesToFuse& input,
              const ReconstructionOptions& options,
              const std::filesystem::path& scratch,
              const base::ProgressCallback& progress) {
    const std::vector<types::Keyframe>& frames = input.frames;
    FusedMap map;
    const double median_m = median_depth_m(input);
    fusion::VolumeSettings settings = settings_of_volume(input, options, median_m, scratch);
    if (input.max_depth_m > 0.0)
        settings.max_depth_m = std::min(settings.max_depth_m, input.max_depth_m);
    map.volume = fusion::make_volume(settings, options);
    map.cloud = fusion::make_cloud(settings, options);
    // Consecutive frames see nearly the same points, so all of them are used only if the cloud's
    // points are to be closer than a voxel requires.
    const std::size_t cloud_step = map.cloud->voxel_m() < 0.5 * settings.voxel_m ? 1 : kCloudStep;
    Progress done;
    done.num_frames = static_cast<std::int64_t>(frames.size());
    base::TaskPool task_pool(options.num_threads);
    const auto voxel_at = [&](double depth_m) {
        return settings.levels->num_levels() == 1
                   ? settings.voxel_m
                   : std::ldexp(settings.median_voxel_m(),
                                fusion::relative_level(input.rig, median_m, depth_m));
    };
    DepthAcrossFrames across(input.rig, frames, input.store, options.across_frames, median_m);
    const auto improve = [&](std::size_t frame, types::KeyframeImages& images) {
        across.improve(frame, images);
    };
    DepthViewPrefetcher views(input.rig, voxel_at, frames, input.store, improve, task_pool);
    // Declared after the map, so that it ends first, also if progress() throws.
    base::BackgroundTask cloud(task_pool);
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

mesh::ExtractedSurface mesh(const fusion::Volume& volume,
                            const ReconstructionOptions& options,
                            const base::ProgressCallback& progress) {
    return mesh::extract_surface(volume, options.mesher, options.num_threads, progress);  // 8
}

}  // namespace divemesh::pipeline
