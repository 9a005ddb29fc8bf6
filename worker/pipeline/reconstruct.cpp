#include "worker/pipeline/reconstruct.hpp"

#include "worker/base/background_task.hpp"
#include "worker/mesh/extract_surface.hpp"
#include "worker/pipeline/depth_view_prefetcher.hpp"
#include "worker/pipeline/optimise_track.hpp"
#include "worker/pipeline/pairwise_tracker.hpp"
#include "worker/pipeline/solver_findings.hpp"
#include "worker/pipeline/window_tracker.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::size_t kCloudStep = 6;  // every n-th mapped frame

types::OptimisedTrack as_tracked(const types::Track& track) {
    types::OptimisedTrack result;
    result.trajectory = track.causal;
    result.keyframes = track.keyframes;
    result.mapped = track.mapped;
    result.rig = track.rig;
    return result;
}

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
    require_tracked(track.statistics);
    const bool whole_dive = options.adjust_whole_dive && options.estimator != "pairwise" &&
                            track.keyframes.size() >= 2;  // the paper ends before this
    types::OptimisedTrack result =
        whole_dive ? optimise_track(track, recording, options, store, progress) : as_tracked(track);
    require_converged(track, result);
    auto findings = track.findings;
    const auto lost = tracking_findings(track.statistics);
    findings.insert(findings.end(), lost.begin(), lost.end());
    result.findings.insert(result.findings.begin(), findings.begin(), findings.end());
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
