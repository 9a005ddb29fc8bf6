#include "worker/evaluation/evaluation.hpp"

#include <algorithm>

#include "schemas/error.hpp"
#include "worker/evaluation/tracking_segments.hpp"

namespace divemesh::evaluation {
namespace {

void add_trajectory_errors(const EvaluationInput& input, Evaluation& evaluation) {
    const auto segments = segments_of(input.trajectory, input.keyframes, input.breaks_ns);
    try {
        evaluation.trajectory =
            trajectory_error(within_largest(input.trajectory, segments), input.ground_truth);
        evaluation.causal =
            trajectory_error(within_largest(input.causal, segments), input.ground_truth);
        evaluation.covariance =
            check_covariances(input.trajectory, input.covariances, input.ground_truth);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        evaluation.findings.push_back({Severity::Warning,
                                       "ground_truth_unusable",
                                       "mav0/state_groundtruth_estimate0/data.csv",
                                       error.what(),
                                       "the result was not compared with it; give the ground truth "
                                       "on the clock of the cameras, or remove it"});
    }
}

void add_surface_error(const EvaluationInput& input, Evaluation& evaluation) {
    SurfaceErrorInput surface;
    surface.T_reference_world = evaluation.trajectory->T_reference_surface;
    for (const types::StampedPose& pose : input.trajectory)
        surface.camera_positions_world.emplace_back(
            (pose.T_world_imu * input.rig.T_imu_cam0).translation());
    surface.pairs = pairs_along(input.trajectory, input.rig);
    surface.scene = input.scene;
    surface.num_threads = input.num_threads;
    try {
        evaluation.surface = surface_error(*input.mesh, *input.reference, surface);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        evaluation.findings.push_back(
            {Severity::Warning,
             "surface_not_measured",
             "reference.ply",
             error.what(),
             "check that both the mesh and the reference contain triangles"});
    }
}

void add_known_distances(const EvaluationInput& input, bool has_truth, Evaluation& evaluation) {
    const KnownPath path{input.trajectory,
                         input.covariances,
                         input.scale_sigma,
                         segments_of(input.trajectory, input.keyframes, input.breaks_ns),
                         input.readout_time_s,
                         input.contradiction_sigma};
    if (!has_truth) {
        evaluation.known_distances =
            measure_known_distances(input.known_distances, nullptr, input.rig, path);
        return;
    }
    std::vector<std::int64_t> timestamps_ns;
    for (const types::Keyframe& keyframe : input.keyframes)
        timestamps_ns.push_back(keyframe.timestamp_ns);
    const SurfaceIndex reference(*input.reference);
    const types::Trajectory true_path = with_mounting_of(
        input.trajectory, input.ground_truth, evaluation.trajectory->T_reference_estimate);
    const MarkingInput truth{input.rig, true_path, timestamps_ns, reference};
    evaluation.known_distances =
        measure_known_distances(input.known_distances, &truth, input.rig, path);
}

}  // namespace

Evaluation evaluate_reconstruction(const EvaluationInput& input) {
    Evaluation evaluation;
    if (!input.ground_truth.empty()) add_trajectory_errors(input, evaluation);
    const bool has_truth = evaluation.trajectory.has_value() && input.reference.has_value();
    if (has_truth && input.mesh != nullptr) add_surface_error(input, evaluation);
    const auto num_unmarked =
        std::count_if(input.known_distances.begin(),
                      input.known_distances.end(),
                      [](const dive::KnownDistance& known) { return !known.is_marked(); });
    const auto num_known = static_cast<std::ptrdiff_t>(input.known_distances.size());
    if (num_known > 0 && (has_truth || num_unmarked < num_known))
        add_known_distances(input, has_truth, evaluation);
    if (!has_truth && num_unmarked > 0)
        evaluation.findings.push_back(
            {Severity::Info,
             "known_distances_not_measured",
             "measurements.json",
             std::to_string(num_unmarked) + " known distances were not measured: their ends are "
                                            "not marked in the images",
             "mark both ends in at least four frames (marks_a, marks_b); points a and b need "
             "ground truth and reference.ply in the dive"});
    return evaluation;
}

}  // namespace divemesh::evaluation
