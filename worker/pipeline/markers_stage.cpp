#include <cmath>
#include <optional>
#include <utility>

#include "worker/base/text.hpp"
#include "worker/camera/rerectifier.hpp"
#include "worker/markers/measure_bars.hpp"
#include "worker/markers/survey_markers.hpp"
#include "worker/pipeline/join_positions.hpp"
#include "worker/pipeline/scale_of_result.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {
namespace {

// Returns the world in which markers are located.
markers::MarkerWorld world_of(const Reconstruction& made) {
    return {made.optimised.rig,
            made.optimised.keyframes,
            made.optimised.trajectory,
            covariances_without_scale(made.optimised),
            made.shutter.get()};
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
                                 {.report = progress},
                                 made.options().num_threads);
}

void correct_scale(const std::vector<markers::TagView>& views, Reconstruction& made) {
    markers::ScaleCorrection correction;
    if (const auto reason = markers::reason_against(made.markers->scale)) {
        made.markers->findings.push_back(*reason);
    } else {
        correction = {true, *made.markers->scale};
        scale_result(correction.scale.factor,
                     std::hypot(correction.scale.sigma, made.markers->systematic_scale_sigma),
                     made);
        made.markers = markers::measure_markers(views, *made.marker_plan, world_of(made));
    }
    made.markers->correction = std::move(correction);
}

Finding corrected_finding(const evaluation::CombinedScale& scale) {
    const auto percent = [](double share) { return base::fixed(100.0 * share, 2) + " %"; };
    std::string names;
    for (const evaluation::ScaleSource& source : scale.sources)
        names += (names.empty() ? "" : ", ") + source.name + " " +
                 percent(source.check.scale - 1.0) + " +- " + percent(source.check.sigma);
    const std::string scaled = " (" + names +
                               " against the cameras), so the whole result was scaled by " +
                               base::fixed(scale.factor, 4) + " +- " + base::fixed(scale.sigma, 4);
    if (!scale.refuted)
        return {
            Severity::Info,
            "scale_corrected",
            "",
            "other measurements of length determine the scale better than the cameras do" + scaled,
            "correct_scale=off leaves the scale as calibrated"};
    return {
        Severity::Warning,
        "scale_corrected",
        "",
        "other measurements of length contradict the calibration of the cameras" + scaled,
        "calibrate the rig again in water, above all its baseline; correct_scale=off leaves the "
        "scale as calibrated"};
}

// Scales the result where the other measurements of length together differ from the cameras, or
// determine the scale better.
void correct_scale_automatically(const std::vector<markers::TagView>& views, Reconstruction& made) {
    made.scale_correction = evaluation::scale_correction(
        scale_sources(made).usable, made.optimised.statistics.path.scale_sigma);
    if (!made.scale_correction) return;
    scale_result(made.scale_correction->factor, made.scale_correction->sigma, made);
    made.optimised.findings.push_back(corrected_finding(*made.scale_correction));
    if (made.markers)
        made.markers = markers::measure_markers(views, *made.marker_plan, world_of(made));
}

}  // namespace

bool markers_wanted(const Reconstruction& made) {
    return !made.has_failed() && (made.marker_plan || made.options().correct_scale == "auto" ||
                                  !made.dive.outside().empty());
}

void run_markers(Reconstruction& made, const base::ProgressCallback& progress) {
    std::vector<markers::TagView> views;
    if (made.marker_plan) {
        views = find_tags(made, progress);
        made.markers = markers::measure_markers(views, *made.marker_plan, world_of(made));
    }
    made.scale_by_positions = scale_by_positions(made);
    if (made.options().correct_scale == "on") correct_scale(views, made);
    if (made.options().correct_scale == "auto") correct_scale_automatically(views, made);
    join_positions(made);
    if (made.markers && made.georeference && made.georeference->path_joined) {
        auto correction = std::move(made.markers->correction);
        made.markers = markers::measure_markers(views, *made.marker_plan, world_of(made));
        made.markers->correction = std::move(correction);
    }
}

}  // namespace divemesh::pipeline
