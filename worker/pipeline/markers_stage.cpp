#include <optional>

#include "worker/camera/rerectifier.hpp"
#include "worker/markers/measure_bars.hpp"
#include "worker/markers/survey_markers.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {
namespace {

markers::MarkerWorld world_of(const types::OptimisedTrack& optimised) {
    return {optimised.rig, optimised.keyframes, optimised.trajectory, optimised.covariances};
}

std::vector<markers::TagView> find_tags(Reconstruction& made,
                                        const base::ProgressCallback& progress) {
    const types::RefinedCalibration& calibration = made.optimised.calibration;
    std::optional<camera::Rerectifier> refined;
    if (calibration.lenses_applied)
        refined.emplace(made.recording.rig(), made.track.rig, calibration.lenses);
    return markers::find_tags_in(made.recording,
                                 made.optimised.keyframes,
                                 made.marker_plan->family,
                                 refined ? &*refined : nullptr,
                                 {.stage = "optimise", .report = progress},
                                 made.options().num_threads);
}

void apply(const markers::WorldScale& scale, types::OptimisedTrack& optimised) {
    optimised.keyframes = scale.applied(optimised.keyframes, optimised.trajectory);
    optimised.mapped = scale.applied(optimised.mapped, optimised.trajectory);
    optimised.predicted = scale.applied(optimised.predicted, optimised.trajectory);
    optimised.trajectory = scale.applied(optimised.trajectory);
    optimised.covariances = scale.applied(optimised.covariances);
}

// Scales all poses. It runs before anything is made from them, so that all results have the same
// scale.
void scale_world(double factor, Reconstruction& made) {
    made.scale.emplace(factor, made.optimised.rig.T_imu_cam);
    apply(*made.scale, made.optimised);
    made.optimised.rig.baseline_m *= factor;
    made.track.causal =
        markers::WorldScale(factor, made.track.rig.T_imu_cam).applied(made.track.causal);
    made.track.statistics.median_depth_m *= factor;
    write_trajectories(made);
}

void correct_scale(const std::vector<markers::TagView>& views, Reconstruction& made) {
    markers::ScaleCorrection correction;
    if (const auto reason = markers::reason_against(made.markers->scale)) {
        made.markers->findings.push_back(*reason);
    } else {
        correction = {true, *made.markers->scale};
        scale_world(correction.scale.factor, made);
        made.markers = markers::measure_markers(views, *made.marker_plan, world_of(made.optimised));
    }
    made.markers->correction = std::move(correction);
}

}  // namespace

bool markers_wanted(const Reconstruction& made) {
    return made.marker_plan.has_value() && !made.has_failed();
}

void run_markers(Reconstruction& made, const base::ProgressCallback& progress) {
    const auto views = find_tags(made, progress);
    made.markers = markers::measure_markers(views, *made.marker_plan, world_of(made.optimised));
    if (made.options().correct_scale) correct_scale(views, made);
}

}  // namespace divemesh::pipeline
