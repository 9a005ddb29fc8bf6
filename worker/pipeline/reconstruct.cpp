#include "worker/pipeline/reconstruct.hpp"

#include <utility>

#include "worker/base/background_task.hpp"
#include "worker/pipeline/depth_view_prefetcher.hpp"
#include "worker/calibration/calibration_refinement.hpp"
#include "worker/optimisation/expected_path_error.hpp"
#include "worker/optimisation/follow_keyframes.hpp"
#include "worker/optimisation/frame_covariances.hpp"
#include "worker/optimisation/global_bundle_adjustment.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/loops/close_loops.hpp"
#include "worker/loops/drift_model.hpp"
#include "worker/loops/find_loops.hpp"
#include "worker/loops/separate_segments.hpp"
#include "worker/types/path_uncertainty.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/base/free_memory.hpp"
#include "worker/pipeline/pairwise_tracker.hpp"
#include "worker/mesh/extract_surface.hpp"
#include "worker/pipeline/window_tracker.hpp"

namespace divemesh::worker {
namespace {

constexpr std::size_t kCloudStep = 6;  // of the mapped frames
// How far a camera sees, in median depths of the dive.
constexpr double kReach = 3.0;

}  // namespace

Track track(Recording& recording,
            const ReconstructionOptions& options,
            const KeyframeStore& store,
            const ProgressCallback& progress) {
    return options.estimator == "pairwise" ? track_pairwise(recording, options, store, progress)
                                           : track_window(recording, options, store, progress);
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
    const DriftModel drift(track.keyframes, track.landmarks, &inertial);
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
    const GlobalBundleAdjustment adjusted =
        adjust_globally(closed.rig, inertial, closed.keyframes, closed.landmarks, progress, at);
    result.statistics.reprojection_rms_px = adjusted.reprojection_rms_px;
    separate_segments(kReach * track.statistics.median_depth_m, closed.keyframes);
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
    TaskPool task_pool(options.num_threads);
    DepthViewPrefetcher views(rig, map.volume->voxel_m(), frames, store, task_pool);
    BackgroundTask cloud(task_pool);  // ends before the map goes, also when progress() throws
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
