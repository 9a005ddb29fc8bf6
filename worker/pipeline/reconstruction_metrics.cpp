#include "worker/pipeline/reconstruction_metrics.hpp"

#include "worker/evaluation/path_length.hpp"
#include "worker/evaluation/surface_samples.hpp"
#include "worker/pipeline/align_cameras.hpp"
#include "worker/pipeline/metrics_document.hpp"

namespace divemesh::pipeline {
namespace {

evaluation::ExpectedAccuracy expected(const Reconstruction& made) {
    const auto& known = made.evaluation.known_distances;
    return evaluation::expected_accuracy(
        {.recording = made.recording,
         .trajectory = made.optimised.trajectory,
         .num_segments =
             evaluation::segments_of(made.optimised.trajectory, made.optimised.keyframes).size(),
         .covariances = made.optimised.covariances,
         .track = made.track.statistics,
         .optimise = made.optimised.statistics,
         .known_distances = known ? &*known : nullptr,
         .mesh = made.request.options.surface ? &made.surface.mesh : nullptr});
}

std::optional<MeshMetrics> mesh_metrics(const Reconstruction& made) {
    if (!made.request.options.surface) return std::nullopt;
    const types::Mesh& mesh = made.surface.mesh;
    return MeshMetrics{.num_vertices = std::ssize(mesh.vertices),
                       .num_triangles = std::ssize(mesh.triangles),
                       .area_m2 = evaluation::surface_area_m2(mesh),
                       .borders = made.borders,
                       .simplification = made.surface.simplification,
                       .voxel_m = made.voxel_m,
                       .cloud = made.cloud,
                       .volume_memory_bytes = made.volume_memory_bytes};
}

// Returns the findings about the dive, then those about its reconstruction.
std::vector<Finding> findings(const Reconstruction& made) {
    std::vector<Finding> all = made.dive.findings();
    const std::vector<Finding> of_cameras = alignment_findings(made.alignment);
    all.insert(all.end(), of_cameras.begin(), of_cameras.end());
    const std::vector<Finding>& later = made.optimised.findings;
    all.insert(all.end(), later.begin(), later.end());
    return all;
}

}  // namespace

evaluation::Evaluation compare_with_truth(const Reconstruction& made) {
    return evaluation::evaluate_reconstruction(
        {.rig = made.scale ? made.scale->applied(made.recording.rig()) : made.recording.rig(),
         .trajectory = made.optimised.trajectory,
         .causal = made.track.causal,
         .covariances = made.optimised.covariances,
         .keyframes = made.optimised.keyframes,
         .mesh = made.request.options.surface ? &made.surface.mesh : nullptr,
         .ground_truth = made.dive.ground_truth(),
         .known_distances = made.dive.known_distances(),
         .reference = made.dive.read_reference_mesh(),
         .num_threads = made.request.options.num_threads});
}

nlohmann::json metrics_of(const Reconstruction& made) {
    return metrics_document(
        {.version = DIVEMESH_VERSION,
         .preset = made.request.preset,
         .options = made.request.options,
         .dive_name = made.dive.info().name,
         .position = made.dive.info().position,
         .content_sha256 = made.dive.content_sha256(),
         .duration_s = made.dive.duration_s(),
         .stated_rig = made.dive.rig(),
         .rig = made.recording.rig(),
         .alignment = made.alignment,
         .gravity = evaluation::check_gravity(made.dive.imu(), made.optimised.trajectory),
         .refined = made.optimised.calibration,
         .end_covariance_m2 = made.optimised.covariances.empty()
                                  ? std::optional<Eigen::Matrix3d>()
                                  : made.optimised.covariances.back().position_m2,
         .track = made.track.statistics,
         .optimise = made.optimised.statistics,
         .num_keyframes = std::ssize(made.optimised.keyframes),
         .num_landmarks = made.num_landmarks,
         .path_length_m = evaluation::path_length_m(made.optimised.trajectory),
         .segments = evaluation::segments_of(made.optimised.trajectory, made.optimised.keyframes),
         .mesh = mesh_metrics(made),
         .markers = made.markers,
         .stages = made.stages,
         .evaluation = made.evaluation,
         .expected = expected(made),
         .findings = findings(made)});
}

}  // namespace divemesh::pipeline
