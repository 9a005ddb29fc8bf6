#include "worker/calibration/stereo_alignment.hpp"
#include "worker/camera/virtual_camera.hpp"
#include "worker/pipeline/align_cameras.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {

bool load_align(Reconstruction& made, const std::string& key) {
    const auto stored = load_rig_alignment(made.scratch("align.stage"), key);
    if (stored) made.alignment = *stored;
    return stored.has_value();
}

void run_align(Reconstruction& made, const base::ProgressCallback& progress) {
    made.alignment = align_cameras(made.dive, made.options().num_threads, progress);
    made.alignment.applied = made.options().align_cameras &&
                             made.alignment.outcome == types::RigAlignment::Outcome::Moved;
}

void save_align(Reconstruction& made, const std::string& key) {
    save_rig_alignment(made.scratch("align.stage"), key, made.alignment);
}

void finish_align(Reconstruction& made) {
    const types::RigAlignment& alignment = made.alignment;
    types::Rig rig = made.dive.rig();
    if (alignment.reference_depth_m > 0.0)
        rig = camera::with_reference_depth(rig, alignment.reference_depth_m);
    if (alignment.applied) rig = calibration::changed_rig(rig, alignment.change);
    if (alignment.applied || alignment.reference_depth_m > 0.0) made.set_rig(rig);
}

}  // namespace divemesh::pipeline
