#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "worker/base/text.hpp"
#include "worker/camera/rerectifier.hpp"
#include "worker/evaluation/scale_check.hpp"
#include "worker/imu/estimate_alignment.hpp"
#include "worker/imu/usable_samples.hpp"
#include "worker/markers/measure_bars.hpp"
#include "worker/markers/survey_markers.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {
namespace {

constexpr double kMaxScaleSigma = 0.05;
constexpr double kMaxShare = 0.99;                  // of a variance that the scale's error may be
constexpr double kMaxCorrection = 0.1;              // beyond it a size was stated wrong
constexpr double kAccelerometerScaleSigma = 0.003;  // of the sensor itself

// Returns the covariances without the error of the scale that all poses share: known lengths
// measure it, and it is no drift between the ends of one.
types::CovarianceTrack without_scale(const types::OptimisedTrack& optimised) {
    types::CovarianceTrack result = optimised.covariances;
    if (optimised.trajectory.empty()) return result;
    const Eigen::Isometry3d T_first_world = optimised.trajectory.front().T_world_imu.inverse();
    auto pose = optimised.trajectory.begin();
    for (types::PoseCovariance& at : result) {
        while (pose != optimised.trajectory.end() && pose->timestamp_ns < at.timestamp_ns) ++pose;
        if (pose == optimised.trajectory.end()) break;
        const Eigen::Vector3d error = optimised.statistics.path.scale_sigma *
                                      (T_first_world * pose->T_world_imu.translation());
        const double sigmas2 = error.dot(at.position_m2.ldlt().solve(error));
        if (sigmas2 > 0.0)
            at.position_m2 -= std::min(1.0, kMaxShare / sigmas2) * error * error.transpose();
    }
    return result;
}

markers::MarkerWorld world_of(const types::OptimisedTrack& optimised) {
    return {optimised.rig, optimised.keyframes, optimised.trajectory, without_scale(optimised)};
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

// Returns what measures lengths beside the cameras, without the cameras' own error.
std::vector<evaluation::ScaleSource> scale_sources(const Reconstruction& made) {
    std::vector<evaluation::ScaleSource> sources;
    const auto add = [&](const char* name, std::optional<evaluation::ScaleCheck> check) {
        if (check && check->sigma < kMaxScaleSigma) sources.push_back({name, *check});
    };
    if (made.markers && made.markers->scale)
        add("markers",
            evaluation::ScaleCheck{
                made.markers->scale->factor,
                std::hypot(made.markers->scale->sigma, made.markers->systematic_scale_sigma)});
    const types::OptimisedTrack& optimised = made.optimised;
    if (!optimised.breaks_ns.empty()) return sources;
    if (made.options().use_imu) {
        auto check = evaluation::scale_by_accelerometer(
            imu::aligned(imu::usable_forces(made.recording, made.track.left_out),
                         {optimised.calibration.applied_alignment().time_offset_s}),
            optimised.trajectory);
        if (check) check->sigma = std::hypot(check->sigma, kAccelerometerScaleSigma);
        add("accelerometer", check);
    }
    if (made.options().use_pressure && !made.track.left_out.pressure)
        add("pressure",
            evaluation::scale_by_pressure(made.recording.pressure(),
                                          optimised.trajectory,
                                          optimised.statistics.path.vertical_scale_sigma));
    return sources;
}

Finding corrected_finding(const evaluation::CombinedScale& scale) {
    const auto percent = [](double share) { return base::fixed(100.0 * share, 2) + " %"; };
    std::string names;
    for (const evaluation::ScaleSource& source : scale.sources)
        names += (names.empty() ? "" : ", ") + source.name + " " +
                 percent(source.check.scale - 1.0) + " +- " + percent(source.check.sigma);
    return {
        Severity::Warning,
        "scale_corrected",
        "",
        "what measures lengths contradicts the cameras' calibration (" + names +
            " against the cameras), so the whole result was scaled by " +
            base::fixed(scale.factor, 4) + " +- " + base::fixed(scale.sigma, 4),
        "calibrate the rig again in water, above all its baseline; correct_scale=off leaves the "
        "scale as calibrated"};
}

// Scales the result where all that measures lengths contradicts the cameras.
void correct_contradicted_scale(const std::vector<markers::TagView>& views, Reconstruction& made) {
    const double cameras_sigma = made.optimised.statistics.path.scale_sigma;
    auto sources = scale_sources(made);
    if (cameras_sigma <= 0.0 || sources.empty()) return;
    const auto scale = evaluation::combined_scale(std::move(sources), cameras_sigma);
    if (!scale.contradicted || std::abs(scale.factor - 1.0) > kMaxCorrection) return;
    made.scale_correction = scale;
    scale_world(scale.factor, made);
    made.optimised.statistics.path.scale_sigma = scale.sigma;
    made.optimised.findings.push_back(corrected_finding(scale));
    if (made.markers)
        made.markers = markers::measure_markers(views, *made.marker_plan, world_of(made.optimised));
}

}  // namespace

bool markers_wanted(const Reconstruction& made) {
    return !made.has_failed() && (made.marker_plan || made.options().correct_scale == "auto");
}

void run_markers(Reconstruction& made, const base::ProgressCallback& progress) {
    std::vector<markers::TagView> views;
    if (made.marker_plan) {
        views = find_tags(made, progress);
        made.markers = markers::measure_markers(views, *made.marker_plan, world_of(made.optimised));
    }
    if (made.options().correct_scale == "on") correct_scale(views, made);
    if (made.options().correct_scale == "auto") correct_contradicted_scale(views, made);
}

}  // namespace divemesh::pipeline
