#include "worker/pipeline/reconstruction_metrics.hpp"

#include <algorithm>

#include "worker/evaluation/scaled_uncertainty.hpp"
#include "worker/evaluation/surface_samples.hpp"
#include "worker/evaluation/tracking_segments.hpp"
#include "worker/pipeline/alignment_findings.hpp"
#include "worker/pipeline/color_metrics.hpp"
#include "worker/pipeline/lever_arm.hpp"
#include "worker/pipeline/measured_poses.hpp"
#include "worker/pipeline/metrics_document.hpp"
#include "worker/pipeline/result_findings.hpp"
#include "worker/pipeline/scale_of_result.hpp"
#include "worker/pipeline/vertical.hpp"

namespace divemesh::pipeline {
namespace {

using Segments = std::vector<types::TrackingSegment>;

double path_length_m(const Segments& segments) {
    double length_m = 0.0;
    for (const types::TrackingSegment& segment : segments) length_m += segment.path_length_m;
    return length_m;
}

evaluation::ExpectedAccuracy expected(const Reconstruction& made, const Segments& segments) {
    return evaluation::expected_accuracy(
        {.recording = made.recording,
         .trajectory = made.optimised.trajectory,
         .num_segments = segments.size(),
         .path_length_m = path_length_m(segments),
         .covariances = made.optimised.covariances,
         .track = made.track.statistics,
         .optimise = made.optimised.statistics,
         .scale = scale_sources(made),
         .mesh = made.request.options.surface ? &made.surface.mesh : nullptr});
}

bool knows_vertical(const Reconstruction& made) {
    imu::InertialPrior inertial(made.recording, made.request.options, made.track.left_out);
    inertial.set_pressure_error(made.track.pressure_error_m);
    return vertical_is_known(inertial, made.optimised);
}

std::optional<MeshMetrics> mesh_metrics(const Reconstruction& made) {
    if (!made.request.options.surface) return std::nullopt;
    const types::Mesh& mesh = made.surface.mesh;
    return MeshMetrics{.num_vertices = std::ssize(mesh.vertices),
                       .num_triangles = std::ssize(mesh.triangles),
                       .area_m2 = evaluation::surface_area_m2(mesh),
                       .borders = made.borders,
                       .coverage = made.coverage,
                       .small_components_m2 = made.surface.small_components_m2,
                       .cut_by_sigma_m2 = made.surface.cut_by_sigma_m2,
                       .simplification = made.surface.simplification,
                       .voxels = made.voxels,
                       .cloud = made.cloud,
                       .volume_memory_bytes = made.volume_memory_bytes};
}

// Returns the findings about the dive, also those on images that an earlier run read.
std::vector<Finding> findings_on_dive(const Reconstruction& made) {
    std::vector<Finding> all = made.dive.findings();
    for (const Finding& read : made.track.image_findings) {
        const bool known = std::ranges::any_of(all, [&](const Finding& finding) {
            return finding.code == read.code && finding.where == read.where;
        });
        if (!known) all.push_back(read);
    }
    return all;
}

// Returns the findings about the dive, then those about its reconstruction.
std::vector<Finding> findings(const Reconstruction& made,
                              const Segments& segments,
                              const evaluation::ExpectedAccuracy& expected,
                              bool vertical_known) {
    std::vector<Finding> all = findings_on_dive(made);
    const std::vector<Finding> of_cameras = alignment_findings(made.alignment);
    all.insert(all.end(), of_cameras.begin(), of_cameras.end());
    const std::vector<Finding>& later = made.optimised.findings;
    all.insert(all.end(), later.begin(), later.end());
    if (made.has_failed()) return all;
    const auto add = [&](const std::optional<Finding>& finding) {
        if (finding) all.push_back(*finding);
    };
    add(segments_finding(segments));
    add(scale_finding(expected));
    add(scale_uncertainty_finding(expected));
    add(bounds_finding(expected, segments.size()));
    add(vertical_finding(vertical_known));
    add(shutter_finding(made.refined()));
    add(lever_arm_finding(made.refined()));
    if (!made.options().surface) return all;
    ReconstructionOptions fused_with = made.options();
    if (made.optimised.max_depth_m > 0.0) fused_with.max_depth_m = made.max_depth_m;
    add(left_out_finding(made.cloud.fused, made.max_depth_m, made.voxels, fused_with));
    add(surface_finding(std::ssize(made.surface.mesh.triangles)));
    if (made.surface.mesh.triangles.empty()) return all;
    add(incomplete_finding(made.coverage, made.surface.cut_by_sigma_m2));
    if (made.color) add(color_finding(*made.color));
    if (made.options().texture)
        add(texture_finding(made.texture, std::ssize(made.optimised.keyframes)));
    return all;
}

}  // namespace

evaluation::Evaluation compare_with_truth(const Reconstruction& made) {
    const types::PathUncertainty& path = made.optimised.statistics.path;
    const types::CovarianceTrack covariances = stated_covariances(made.optimised);
    const std::optional<types::Mesh> scene = made.dive.read_scene_mesh();
    return evaluation::evaluate_reconstruction(
        {.rig = made.used_rig(),
         .trajectory = made.optimised.trajectory,
         .causal = measured_causal(made.track),
         .covariances = covariances,
         .keyframes = made.optimised.keyframes,
         .breaks_ns = made.optimised.breaks_ns,
         .mesh = made.request.options.surface ? &made.surface.mesh : nullptr,
         .ground_truth = made.dive.ground_truth(),
         .known_distances = made.dive.known_distances(),
         .reference = made.dive.read_reference_mesh(),
         .num_threads = made.request.options.num_threads,
         .scale_sigma = evaluation::lengths_sigma(path),
         .readout_time_s = made.optimised.calibration.applied_readout_time_s(),
         .contradiction_sigma = evaluation::contradiction_sigma(path.scale_contradiction),
         .scene = scene ? &*scene : nullptr});
}

nlohmann::json metrics_of(const Reconstruction& made) {
    const Segments segments = evaluation::segments_of(
        made.optimised.trajectory, made.optimised.keyframes, made.optimised.breaks_ns);
    const evaluation::ExpectedAccuracy accuracy = expected(made, segments);
    const types::CovarianceTrack covariances = stated_covariances(made.optimised);
    const bool vertical_known = knows_vertical(made);
    return metrics_document(
        {.version = DIVEMESH_VERSION,
         .preset = made.request.preset,
         .options = made.request.options,
         .dive_name = made.dive.info().name,
         .position = made.position(),
         .georeference = made.georeference,
         .content_sha256 = made.dive.content_sha256(),
         .duration_s = made.dive.duration_s(),
         .stated_rig = made.dive.rig(),
         .rig = made.recording.recorded_rig(),
         .used_rig = made.used_rig(),
         .alignment = made.alignment,
         .gravity = evaluation::check_gravity(made.dive.imu(), made.optimised.trajectory),
         .refined = made.refined(),
         .end_covariance_m2 = covariances.empty() ? std::optional<Eigen::Matrix3d>()
                                                  : covariances.back().position_m2,
         .track = made.track.statistics,
         .reduction = made.track.reduction,
         .optimise = made.optimised.statistics,
         .num_keyframes = std::ssize(made.optimised.keyframes),
         .num_landmarks = made.num_landmarks,
         .num_frames_by_imu = std::count(
             made.track.motions.begin(), made.track.motions.end(), types::MotionSource::Imu),
         .num_frames_predicted = std::ssize(made.optimised.predicted),
         .path_length_m = path_length_m(segments),
         .vertical_is_known = vertical_known,
         .segments = segments,
         .mesh = mesh_metrics(made),
         .texture = made.request.options.surface ? std::optional(made.texture) : std::nullopt,
         .color = made.color ? &*made.color : nullptr,
         .markers = made.markers,
         .scale_correction = made.scale_correction,
         .stages = made.stages,
         .evaluation = made.evaluation,
         .expected = accuracy,
         .findings = findings(made, segments, accuracy, vertical_known)});
}

}  // namespace divemesh::pipeline
