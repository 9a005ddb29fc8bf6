#include "worker/pipeline/scale_of_result.hpp"

#include <cmath>
#include <utility>

#include "worker/evaluation/scaled_uncertainty.hpp"
#include "worker/evaluation/tracking_segments.hpp"
#include "worker/imu/estimate_alignment.hpp"
#include "worker/imu/usable_samples.hpp"
#include "worker/io/ply.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {
namespace {

std::vector<types::ImuSample> usable_imu(const Reconstruction& made) {
    if (!made.options().use_imu) return {};
    return imu::aligned(imu::usable_forces(made.recording, made.track.left_out),
                        {made.optimised.calibration.applied_alignment().time_offset_s});
}

std::optional<evaluation::ScaleCheck> by_markers(const Reconstruction& made) {
    if (!made.markers || !made.markers->trusted_scale) return std::nullopt;
    const markers::MarkerScale& scale = *made.markers->trusted_scale;
    return evaluation::ScaleCheck{scale.factor,
                                  std::hypot(scale.sigma, made.markers->systematic_scale_sigma)};
}

std::vector<types::TrackingSegment> segments_of(const types::OptimisedTrack& optimised) {
    return evaluation::segments_of(optimised.trajectory, optimised.keyframes, optimised.breaks_ns);
}

// Returns the known distances whose ends are marked in the images, measured with the poses as they
// are.
evaluation::KnownDistanceErrors measure_marked_distances(const Reconstruction& made) {
    std::vector<dive::KnownDistance> marked;
    for (const dive::KnownDistance& known : made.dive.known_distances())
        if (known.is_marked()) marked.push_back(known);
    if (marked.empty()) return {};
    const types::OptimisedTrack& optimised = made.optimised;
    const types::CovarianceTrack covariances = covariances_without_scale(optimised);
    return evaluation::measure_known_distances(
        marked,
        nullptr,
        made.used_rig(),
        {.trajectory = optimised.trajectory,
         .covariances = covariances,
         .scale_sigma = 0.0,
         .segments = segments_of(optimised),
         .readout_time_s = optimised.calibration.applied_readout_time_s()});
}

void apply(const markers::WorldScale& scale, types::OptimisedTrack& optimised) {
    optimised.keyframes = scale.applied(optimised.keyframes, optimised.trajectory);
    optimised.mapped = scale.applied(optimised.mapped, optimised.trajectory);
    optimised.predicted = scale.applied(optimised.predicted, optimised.trajectory);
    optimised.trajectory = scale.applied(optimised.trajectory);
    optimised.covariances = scale.applied(optimised.covariances);
}

types::CovarianceTrack with_scale_sigma(const types::OptimisedTrack& optimised,
                                        double from_sigma,
                                        double to_sigma) {
    return evaluation::with_scale_sigma(
        optimised.covariances,
        evaluation::offsets_from_start(optimised.trajectory, segments_of(optimised)),
        from_sigma,
        to_sigma);
}

// Replaces the error of the scale by `sigma`, after the scaling.
void replace_scale_error(double factor, double sigma, types::OptimisedTrack& optimised) {
    types::PathUncertainty& path = optimised.statistics.path;
    optimised.covariances = with_scale_sigma(optimised, path.shared_scale_sigma, sigma);
    path = evaluation::scaled(path, factor, sigma);
}

}  // namespace

types::CovarianceTrack covariances_without_scale(const types::OptimisedTrack& optimised) {
    return with_scale_sigma(optimised, optimised.statistics.path.shared_scale_sigma, 0.0);
}

types::CovarianceTrack stated_covariances(const types::OptimisedTrack& optimised) {
    const double contradiction = optimised.statistics.path.scale_contradiction;
    return with_scale_sigma(optimised, 0.0, evaluation::contradiction_sigma(contradiction));
}

evaluation::ScaleSources scale_sources(const Reconstruction& made) {
    const types::OptimisedTrack& optimised = made.optimised;
    const auto& known = made.evaluation.known_distances;
    const bool uses_pressure = made.options().use_pressure && !made.track.left_out.pressure;
    return evaluation::scale_sources(
        {.imu = usable_imu(made),
         .pressure =
             uses_pressure ? made.recording.pressure() : std::vector<types::PressureSample>(),
         .markers = by_markers(made),
         .positions = made.scale_by_positions,
         .marked_distances = measure_marked_distances(made),
         .known_distances = known ? &*known : nullptr,
         .num_segments = segments_of(optimised).size()},
        optimised.trajectory,
        optimised.statistics.path,
        optimised.statistics.loops);
}

void scale_result(double factor, double sigma, Reconstruction& made) {
    made.scale.emplace(factor, made.optimised.rig.T_imu_cam);
    apply(*made.scale, made.optimised);
    replace_scale_error(factor, sigma / factor, made.optimised);
    made.optimised.rig.baseline_m *= factor;
    made.optimised.max_depth_m *= factor;
    if (made.scale_by_positions) made.scale_by_positions->scale /= factor;
    made.track.causal =
        markers::WorldScale(factor, made.track.rig.T_imu_cam).applied(made.track.causal);
    made.track.statistics.median_depth_m *= factor;
    write_trajectories(made);
}

bool cover_contradiction(Reconstruction& made) {
    if (made.has_failed()) return false;
    types::PathUncertainty& path = made.optimised.statistics.path;
    path.scale_contradiction = evaluation::scale_contradiction(scale_sources(made).usable, path);
    if (path.scale_contradiction == 0.0) return false;
    write_trajectories(made);
    const double sigma = evaluation::contradiction_sigma(path.scale_contradiction);
    if (made.markers)
        for (markers::BarMetrics& bar : made.markers->bars)
            bar.sigma_m = std::hypot(bar.sigma_m, sigma * bar.measured_m.value_or(0.0));
    if (!surface_wanted(made)) return true;
    types::Mesh& mesh = made.surface.mesh;
    mesh = evaluation::with_scale_sigma(
        std::move(mesh), made.optimised.trajectory, segments_of(made.optimised), 0.0, sigma);
    io::write_ply(made.artifact("mesh.ply"), mesh);
    return true;
}

}  // namespace divemesh::pipeline
