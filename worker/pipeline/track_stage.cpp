#include "worker/io/trajectory_file.hpp"
#include "worker/pipeline/measured_poses.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/pipeline/stage_functions.hpp"
#include "worker/pipeline/track_reduced.hpp"

namespace divemesh::pipeline {

bool load_track(Reconstruction& made, const std::string& key) {
    auto stored = load_track(made.scratch("track.stage"), key);
    if (stored) made.track = std::move(*stored);
    return stored.has_value();
}

void run_track(Reconstruction& made, const base::ProgressCallback& progress) {
    made.keyframe_store.clear();
    made.track = track(made.recording, made.options(), made.keyframe_store, progress);
    const int reduction = better_reduction(
        made.track, made.options(), made.scratch("reduced"), made.recording, progress);
    if (reduction == 1) return;
    made.set_reduction(reduction);
    made.keyframe_store.clear();
    made.track = track(made.recording, made.options(), made.keyframe_store, progress);
    made.track.reduction = reduction;
    made.track.findings.push_back(reduced_finding(reduction));
}

void save_track(Reconstruction& made, const std::string& key) {
    save_track(made.scratch("track.stage"), key, made.track);
}

void finish_track(Reconstruction& made) {
    if (made.track.reduction != made.recording.reduction())
        made.set_reduction(made.track.reduction);
    io::write_tum(made.artifact("trajectory_causal.tum"), measured_causal(made.track));
}

}  // namespace divemesh::pipeline
