#include "worker/pipeline/track_frames.hpp"

#include <algorithm>

#include "worker/base/background_task.hpp"
#include "worker/pipeline/frame_prefetcher.hpp"
#include "worker/pipeline/unusable_pair_log.hpp"

namespace divemesh::pipeline {
namespace {

void report(const base::ProgressCallback& progress,
            std::size_t num_done,
            const types::Recording& recording) {
    Progress at;
    at.frames_done = static_cast<std::int64_t>(num_done);
    at.num_frames = recording.num_frames();
    at.fraction = static_cast<double>(num_done) / std::max(1, recording.num_frames());
    progress(at);
}

// Returns true if vision says that the frame has the pose of the one before it: the rig rests.
bool rests(const TrackedFrame& frame) {
    constexpr double kRounding = 1e-9;
    return frame.by_vision &&
           frame.T_current_previous.isApprox(Eigen::Isometry3d::Identity(), kRounding);
}

types::MotionSource source_of(const TrackedFrame& frame) {
    if (frame.by_vision) return types::MotionSource::Vision;
    return frame.predicted_by_imu ? types::MotionSource::Imu : types::MotionSource::Nothing;
}

}  // namespace

types::Track track_frames(types::Recording& recording,
                          const camera::Rectifier& rectifier,
                          const ReconstructionOptions& options,
                          const keyframes::KeyframeStore& store,
                          FrameTracker& tracker,
                          const base::ProgressCallback& progress) {
    types::Track result;
    result.rig = rectifier.rig();
    const Eigen::Isometry3d T_cam_imu = result.rig.T_imu_cam.inverse();
    base::TaskPool task_pool(options.num_threads);
    FramePrefetcher frames(recording, rectifier, task_pool);
    keyframes::KeyframeWriter writer(options, store, task_pool);
    Eigen::Isometry3d T_start_cam = Eigen::Isometry3d::Identity();
    UnusablePairLog unusable;
    while (const auto frame = frames.next()) {
        unusable.add_frame(frame->index, frame->timestamp_ns);
        const TrackedFrame tracked = tracker.process(*frame);
        writer.go_on(tracked.dynamic_before);
        if (tracked.to_map) {
            writer.write(tracked.to_map->frame, tracked.to_map->depth, tracked.to_map->seen);
            result.mapped.push_back({frame->index, frame->timestamp_ns, tracked.T_world_cam});
        }
        T_start_cam = T_start_cam * tracked.T_current_previous.inverse();
        result.causal.push_back({frame->timestamp_ns, tracked.T_world_cam * T_cam_imu});
        result.odometry.push_back({frame->timestamp_ns, T_start_cam * T_cam_imu});
        result.sigmas.push_back(rests(tracked) ? types::MotionSigma{} : tracked.sigma);
        result.motions.push_back(source_of(tracked));
        result.features.push_back(tracked.features);
        report(progress, result.causal.size(), recording);
        if (tracker.must_restart()) break;
    }
    writer.finish();
    result.unusable = unusable.finish(recording.num_frames());
    tracker.move_to(result);
    result.statistics.num_skipped_frames = recording.num_skipped_frames();
    result.statistics.dense = writer.statistics();
    return result;
}

}  // namespace divemesh::pipeline
