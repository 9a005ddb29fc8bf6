#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <utility>

#include "worker/calibration/undo_rolling_shutter.hpp"
#include "worker/camera/range_correction.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/camera/shutter_correction.hpp"
#include "worker/camera/virtual_camera.hpp"
#include "worker/io/covariance_file.hpp"
#include "worker/io/trajectory_file.hpp"
#include "worker/pipeline/measured_poses.hpp"
#include "worker/pipeline/scale_of_result.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {
namespace {

std::shared_ptr<const camera::ShutterCorrection> shutter_correction(const Reconstruction& made) {
    const auto found = calibration::camera_motions(made.track, made.track.mapped);
    std::map<int, camera::CameraMotion> motions;
    for (std::size_t i = 0; i < found.size(); ++i)
        if (found[i]) motions[made.track.mapped[i].frame_index] = *found[i];
    return std::make_shared<camera::ShutterCorrection>(
        made.track.rig,
        camera::rectified_lenses(made.recording.rig())[0],  // refined ones lie as far, for rows
        made.optimised.calibration.readout_time_s,
        std::move(motions),
        made.options().num_threads);
}

}  // namespace

void write_trajectories(const Reconstruction& made) {
    io::write_tum(made.artifact("trajectory.tum"), made.optimised.trajectory);
    io::write_covariances(made.artifact("trajectory_covariance.csv"),
                          stated_covariances(made.optimised));
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
        made.track,
        made.recording,
        made.options(),
        made.keyframe_store,
        alignment,
        progress,
        made.dive.outside().empty() ? optimisation::WithPrior::No : optimisation::WithPrior::Yes);
}

void save_optimise(Reconstruction& made, const std::string& key) {
    save_optimised_track(made.scratch("optimise.stage"), key, made.optimised);
}

void finish_optimise(Reconstruction& made) {
    const types::RefinedCalibration& calibration = made.optimised.calibration;
    if (made.options().surface && camera::has_port(made.recording.rig()))
        made.keyframe_store = made.keyframe_store.at_own_range(
            camera::range_table(made.recording.rig(), made.track.rig, made.options().num_threads));
    if (made.options().surface && calibration.lenses_applied)
        made.keyframe_store =
            made.keyframe_store.rerectified(std::make_shared<camera::KeyframeRerectifier>(
                made.track.rig,
                camera::Rerectifier(made.recording.rig(), made.track.rig, calibration.lenses),
                made.options().num_threads));
    if (calibration.readout_time_applied) made.shutter = shutter_correction(made);
    if (made.options().surface && made.shutter)
        made.keyframe_store = made.keyframe_store.corrected(made.shutter);
    write_trajectories(made);
    // Frees memory that the later stages of an hour-long dive need.
    made.num_landmarks = std::ssize(made.track.landmarks);
    made.track.landmarks = {};
    made.track.odometry = {};
}

}  // namespace divemesh::pipeline
