#include "worker/calibration/stereo_alignment.hpp"
#include "worker/camera/virtual_camera.hpp"
#include "worker/pipeline/align_cameras.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {
namespace {

using Outcome = types::RigAlignment::Outcome;

std::vector<types::CameraTurn> camera_turns(const std::vector<types::RigPart>& parts) {
    std::vector<types::CameraTurn> turns;
    for (const types::RigPart& part : parts)
        turns.push_back(
            {part.from_ns, part.values.head<3>(), part.values[types::RigChange::kFocal]});
    return turns;
}

}  // namespace

bool load_align(Reconstruction& made, const std::string& key) {
    const auto stored = load_rig_alignment(made.scratch("align.stage"), key);
    if (stored) made.alignment = *stored;
    return stored.has_value();
}

void run_align(Reconstruction& made, const base::ProgressCallback& progress) {
    made.alignment = align_cameras(made.dive, made.options().num_threads, progress);
    made.alignment.applied =
        made.options().align_cameras &&
        (made.alignment.outcome == Outcome::Moved || !made.alignment.parts.empty());
}

void save_align(Reconstruction& made, const std::string& key) {
    save_rig_alignment(made.scratch("align.stage"), key, made.alignment);
}

void finish_align(Reconstruction& made) {
    const types::RigAlignment& alignment = made.alignment;
    types::Rig rig = made.dive.rig();
    if (alignment.reference_depth_m > 0.0)
        rig = camera::with_reference_depth(rig, alignment.reference_depth_m);
    if (alignment.applied && alignment.outcome == Outcome::Moved)
        rig = calibration::changed_rig(rig, alignment.change);
    if (alignment.applied) rig.right_turns = camera_turns(alignment.parts);
    if (alignment.applied || alignment.reference_depth_m > 0.0) made.set_rig(rig);
}

}  // namespace divemesh::pipeline
