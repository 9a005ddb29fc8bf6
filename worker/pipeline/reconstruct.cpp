#include "worker/pipeline/reconstruct.hpp"

#include <utility>

#include "worker/base/background_task.hpp"
#include "worker/base/free_memory.hpp"
#include "worker/calibration/calibration_refinement.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/loops/close_loops.hpp"
#include "worker/loops/drift_model.hpp"
#include "worker/loops/find_loops.hpp"
#include "worker/loops/separate_segments.hpp"
#include "worker/mesh/extract_surface.hpp"
#include "worker/optimisation/expected_path_error.hpp"
#include "worker/optimisation/follow_keyframes.hpp"
#include "worker/optimisation/frame_covariances.hpp"
#include "worker/optimisation/global_bundle_adjustment.hpp"
#include "worker/pipeline/depth_view_prefetcher.hpp"
#include "worker/pipeline/pairwise_tracker.hpp"
#include "worker/pipeline/window_tracker.hpp"
#include "worker/types/path_uncertainty.hpp"
#include "worker/types/pose_covariance.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::size_t kCloudStep = 6;  // every n-th mapped frame
// How far a camera sees, in median depths of the dive.
constexpr double kReach = 3.0;

}  // namespace

types::Track track(types::Recording& recording,
                   const ReconstructionOptions& options,
                   const keyframes::KeyframeStore& store,
                   const base::ProgressCallback& progress) {
    return options.estimator == "pairwise" ? track_pairwise(recording, options, store, progress)
                                           : track_window(recording, options, store, progress);
}

types::OptimisedTrack optimise(const types::Track& track,
                               const types::Recording& recording,
                               const ReconstructionOptions& options,
                               const keyframes::KeyframeStore& store,
                               const base::ProgressCallback& progress) {
    types::OptimisedTrack result;
    if (!options.adjust_whole_dive || options.estimator == "pairwise" ||
        track.keyframes.size() < 2) {  // the paper ends here
        result.trajectory = track.causal;
        result.keyframes = track.keyframes;
        result.mapped = track.mapped;
        result.rig = track.rig;
        return result;
    }
    imu::InertialPrior inertial(recording, options);
    Progress at;
    at.fraction = 0.1;
    const loops::DriftModel drift(track.keyframes, track.landmarks, &inertial);
    loops::FoundLoops found;
    if (options.close_loops)
        found = loops::find_loops(
            track, drift, store, static_cast<std::uint64_t>(options.seed), progress);
    result.statistics.loops = found.statistics;
    base::return_freed_memory();
    types::Track closed;  // the parts that change from here on
    closed.rig = track.rig;
    closed.odometry = track.odometry;
    closed.keyframes = track.keyframes;
    closed.landmarks = track.landmarks;
    closed.imu_alignment = track.imu_alignment;
    loops::close_loops(closed.rig, found.loops, drift, closed.keyframes, closed.landmarks);
    at.fraction = 0.4;
    result.calibration =
        calibration::refine_calibration(closed, recording, options, inertial, progress, at);
    inertial.align({result.calibration.applied_alignment().time_offset_s});
    calibration::apply_calibration(recording.rig(), result.calibration, closed);
    base::return_freed_memory();
    at.fraction = 0.6;
    const optimisation::GlobalBundleAdjustment adjusted = optimisation::adjust_globally(
        closed.rig, inertial, closed.keyframes, closed.landmarks, progress, at);
    result.statistics.reprojection_rms_px = adjusted.reprojection_rms_px;
    loops::separate_segments(kReach * track.statistics.median_depth_m, closed.keyframes);
    result.trajectory =
        optimisation::follow_keyframes(closed.odometry, closed.keyframes, closed.rig.T_imu_cam);
    result.covariances = optimisation::covariances_at(
        adjusted.covariances, closed.odometry, closed.keyframes, closed.rig.T_imu_cam);
    result.statistics.path =
        optimisation::with_frames_between(adjusted.path, adjusted.covariances, result.covariances);
    loops::add_residuals(found.loops, closed.keyframes, result.statistics.loops);
    result.mapped = optimisation::posed_by(
        result.trajectory, closed.keyframes, closed.rig.T_imu_cam, track.mapped);
    result.keyframes = std::move(closed.keyframes);
    result.rig = closed.rig;
    return result;
}

FusedMap fuse(const types::RectifiedRig& rig,
              const std::vector<types::Keyframe>& frames,
              double median_depth_m,
              const ReconstructionOptions& options,
              const keyframes::KeyframeStore& store,
              const std::filesystem::path& scratch,
              const base::ProgressCallback& progress) {
    FusedMap map;
    map.volume = fusion::make_volume(rig, options, median_depth_m, scratch);
    map.cloud = fusion::make_cloud(map.volume->settings(), options);
    // Consecutive frames see nearly the same points, so all of them are used only if the cloud's
    // points are to be closer than a voxel requires.
    const std::size_t cloud_step =
        map.cloud->voxel_m() < 0.5 * map.volume->voxel_m() ? 1 : kCloudStep;
    Progress done;
    done.stage = "fuse";
    done.num_frames = static_cast<std::int64_t>(frames.size());
    base::TaskPool task_pool(options.num_threads);
    DepthViewPrefetcher views(rig, map.volume->voxel_m(), frames, store, task_pool);
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

types::Mesh mesh(const fusion::Volume& volume,
                 const ReconstructionOptions& options,
                 const base::ProgressCallback& progress) {
    return mesh::extract_surface(volume, options, progress);  // 8
}

}  // namespace divemesh::pipeline
