#include "worker/camera/range_correction.hpp"
#include "worker/dive/image_survey.hpp"
#include "worker/io/trajectory_file.hpp"
#include "worker/pipeline/measured_poses.hpp"
#include "worker/pipeline/move_to_own_range.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/pipeline/stage_functions.hpp"
#include "worker/pipeline/track_reduced.hpp"
#include "worker/pipeline/tracking_findings.hpp"

namespace divemesh::pipeline {
namespace {

void run_reduced(Reconstruction& made, int reduction, const base::ProgressCallback& progress) {
    if (reduction != made.recording.reduction()) made.set_reduction(reduction);
    made.keyframe_store.clear();
    made.track = track(made.recording, made.options(), made.keyframe_store, progress);
    made.track.reduction = reduction;
}

// Returns the findings on all images together, as at intake. Reads the images again.
std::vector<Finding> findings_on_all_images(dive::Dive& dive,
                                            const base::ProgressCallback& progress) {
    dive.rewind();
    dive::FindingLog findings;
    const auto survey = dive::survey_images(dive, [&](Progress at) {
        at.fraction = 1.0;  // of the tracking
        progress(at);
    });
    survey.report(dive.num_frames(), findings);
    return findings.all();
}

}  // namespace

bool load_track(Reconstruction& made, const std::string& key) {
    auto stored = load_track(made.scratch("track.stage"), key);
    if (stored) made.track = std::move(*stored);
    return stored.has_value();
}

void run_track(Reconstruction& made, const base::ProgressCallback& progress) {
    const auto num_known = std::ssize(made.dive.findings());
    const int by_width = reduction_to_width(made.recording.recorded_rig().cam0.width_px,
                                            made.options().max_width_px);
    run_reduced(made, by_width, progress);
    const int better = better_reduction(
        made.track, made.options(), made.scratch("reduced"), made.recording, progress);
    if (better > by_width) {
        run_reduced(made, better, progress);
        made.track.findings.push_back(soft_images_finding(better));
    } else if (by_width > 1) {
        made.track.findings.push_back(large_images_finding(by_width));
    }
    if (const auto ranges =
            camera::range_table(made.recording.rig(), made.track.rig, made.options().num_threads))
        move_to_own_range(*ranges, made.track);
    const std::vector<Finding>& on_dive = made.dive.findings();
    std::vector<Finding>& on_images = made.track.image_findings;
    on_images.assign(on_dive.begin() + num_known, on_dive.end());
    if (!too_little_tracked(made.track)) return;
    // Black images, or none that decode, are a cause.
    const std::vector<Finding> on_all = findings_on_all_images(made.dive, progress);
    on_images.insert(on_images.end(), on_all.begin(), on_all.end());
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
