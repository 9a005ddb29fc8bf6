#include <filesystem>
#include <iterator>
#include <memory>

#include "worker/io/covariance_file.hpp"
#include "worker/io/trajectory_file.hpp"
#include "worker/pipeline/measured_poses.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {

void write_trajectories(const Reconstruction& made) {
    io::write_tum(made.artifact("trajectory.tum"), made.optimised.trajectory);
    io::write_covariances(made.artifact("trajectory_covariance.csv"), made.optimised.covariances);
    io::write_tum(made.artifact("trajectory_causal.tum"), measured_causal(made.track));
    const auto predicted = made.artifact("trajectory_predicted.tum");
    if (made.optimised.predicted.empty())
        std::filesystem::remove(predicted);
    else
        io::write_tum(predicted,
                      made.optimised.predicted,
                      "predicted by the motion model: nothing measured these poses");
}

bool load_optimise(Reconstruction& made, const std::string& key) {
    auto stored = load_optimised_track(made.scratch("optimise.stage"), key);
    if (stored) made.optimised = std::move(*stored);
    return stored.has_value();
}

void run_optimise(Reconstruction& made, const base::ProgressCallback& progress) {
    types::RigAlignment alignment = made.alignment;  // in px as recorded
    alignment.disparity_bias_px /= made.track.reduction;
    alignment.disparity_bias_sigma_px /= made.track.reduction;
    made.optimised = optimise(
        made.track, made.recording, made.options(), made.keyframe_store, alignment, progress);
}

void save_optimise(Reconstruction& made, const std::string& key) {
    save_optimised_track(made.scratch("optimise.stage"), key, made.optimised);
}

void finish_optimise(Reconstruction& made) {
    const types::RefinedCalibration& calibration = made.optimised.calibration;
    if (made.options().surface && calibration.lenses_applied)
        made.keyframe_store =
            made.keyframe_store.rerectified(std::make_shared<camera::KeyframeRerectifier>(
                made.track.rig,
                camera::Rerectifier(made.recording.rig(), made.track.rig, calibration.lenses)));
    write_trajectories(made);
    // Frees memory that the later stages of an hour-long dive need.
    made.num_landmarks = std::ssize(made.track.landmarks);
    made.track.landmarks = {};
    made.track.odometry = {};
}

}  // namespace divemesh::pipeline
