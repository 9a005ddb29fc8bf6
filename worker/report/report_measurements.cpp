#include "worker/report/report_measurements.hpp"

#include <algorithm>
#include <utility>

#include "schemas/error.hpp"
#include "worker/evaluation/known_distances.hpp"
#include "worker/evaluation/mesh_without_contradiction.hpp"
#include "worker/evaluation/relative_pose_error.hpp"
#include "worker/evaluation/scaled_uncertainty.hpp"
#include "worker/evaluation/surface_index.hpp"
#include "worker/evaluation/tracking_segments.hpp"
#include "worker/markers/world_scale.hpp"
#include "worker/reef/measure_reconstruction.hpp"
#include "worker/report/error_map.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;

evaluation::RegisteredTruth register_for(const types::Trajectory& path,
                                         const io::TrajectoryFile& truth,
                                         const TruthOptions& options) {
    if (truth.format != io::TrajectoryFormat::Kitti)
        return evaluation::registered_truth(path, truth.poses, options);
    evaluation::RegisteredTruth registered;
    registered.poses = truth.poses;
    registered.options.pair_by_index = true;
    return registered;
}

// Compares a reconstruction with one truth.
class Measuring {
public:
    Measuring(const ReportInputs& inputs,
              const AccuracyReportRequest& request,
              ReportMeasurements& result)
        : inputs_(inputs), request_(request), result_(result) {
        result_.document = inputs.reconstruction.metrics();
        if (inputs.reconstruction.has_poses())
            result_.path = evaluation::within_largest(inputs.reconstruction.trajectory(),
                                                      inputs.reconstruction.segments());
        result_.findings = inputs.findings;
    }

    void measure(const base::ProgressCallback& progress) {
        if (result_.path.empty()) return;  // nothing was tracked, as the findings say
        if (inputs_.truth) compare_trajectories();
        progress({.stage = "evaluate", .fraction = 0.3});
        if (inputs_.reference) compare_surfaces(progress);
        if (!inputs_.known_distances.empty()) measure_distances();
        if (request_.areas) measure_reef();
    }

private:
    void compare_trajectories();
    void compare_surfaces(const base::ProgressCallback& progress);
    void measure_distances();
    void measure_reef();
    types::Trajectory true_body_path() const;
    std::optional<types::Rig> used_rig() const;

    void cannot(const char* code,
                const std::string& where,
                const std::string& why,
                const char* remedy) {
        result_.findings.push_back({Severity::Warning, code, where, why, remedy});
    }

    const ReportInputs& inputs_;
    const AccuracyReportRequest& request_;
    evaluation::RegisteredTruth registered_;
    ReportMeasurements& result_;
};

void Measuring::compare_trajectories() try {
    registered_ = register_for(result_.path, *inputs_.truth, request_.truth);
    const evaluation::TruthRegistration& registration = registered_.registration;
    const types::Trajectory& poses = registered_.poses;
    const evaluation::TrajectoryErrorOptions& options = registered_.options;
    result_.trajectory = evaluation::trajectory_error(result_.path, poses, options);
    result_.has_orientation = registration.has_orientation;
    const auto known_sections = [&](json metrics) {
        return registration.has_orientation ? metrics
                                            : evaluation::without_rotations(std::move(metrics));
    };
    json& section = result_.document["trajectory"];
    json final_path = evaluation::to_metrics(*result_.trajectory);
    final_path["relative_pose"] = evaluation::to_metrics(evaluation::relative_pose_error(
        evaluation::pair_poses(result_.path, poses, options), {.delta_m = 1.0}));
    section["final"] = known_sections(std::move(final_path));
    if (inputs_.truth_source != "dive" && section.contains("covariance"))
        section["covariance"].erase("check");
    section.erase("causal");
    if (std::filesystem::exists(inputs_.reconstruction.path() / "trajectory_causal.tum") &&
        !options.pair_by_index)
        section["causal"] = known_sections(evaluation::to_metrics(evaluation::trajectory_error(
            evaluation::within_largest(inputs_.reconstruction.causal_trajectory(),
                                       inputs_.reconstruction.segments()),
            poses,
            options)));
    result_.document["truth"] = evaluation::to_metrics(registration, request_.truth);
} catch (const Error& error) {
    if (error.code() != ErrorCode::BadData) throw;
    result_.trajectory.reset();
    result_.document["trajectory"].erase("final");
    result_.document["trajectory"].erase("causal");
    cannot("ground_truth_unusable",
           inputs_.truth_source,
           error.what(),
           "give a ground truth of this dive, on the same clock or with time offset and lever arm");
}

void Measuring::compare_surfaces(const base::ProgressCallback& progress) try {
    if (!inputs_.reconstruction.has_surface()) return;
    if (!result_.trajectory) {
        cannot("surface_not_measured",
               "reference",
               "the mesh cannot be aligned with the reference: there is no true trajectory",
               "give the ground truth trajectory in the world of the reference");
        return;
    }
    const types::Mesh mesh = inputs_.reconstruction.mesh();
    progress({.stage = "evaluate", .fraction = 0.4});
    const auto T_imu_cam0 = inputs_.reconstruction.T_imu_cam0();
    evaluation::SurfaceErrorInput input;
    input.T_reference_world = result_.trajectory->T_reference_surface;
    input.num_samples = request_.num_surface_samples;
    input.num_threads = request_.num_threads;
    for (const types::StampedPose& pose : inputs_.reconstruction.trajectory())
        input.camera_positions_world.emplace_back(
            (T_imu_cam0 ? pose.T_world_imu * *T_imu_cam0 : pose.T_world_imu).translation());
    if (const auto rig = inputs_.reconstruction.rig())
        input.pairs = evaluation::pairs_along(inputs_.reconstruction.trajectory(), *rig);
    if (inputs_.scene) input.scene = &*inputs_.scene;
    result_.surface = evaluation::surface_error(mesh, *inputs_.reference, input);
    result_.document["surface"] = evaluation::to_metrics(*result_.surface);
    progress({.stage = "evaluate", .fraction = 0.7});
    const ErrorMap map =
        render_error_map(mesh, inputs_.scene ? *inputs_.scene : *inputs_.reference, input);
    result_.error_map_png = map.png;
    result_.error_map_end_m = map.end_m;
    progress({.stage = "evaluate", .fraction = 0.8});
} catch (const Error& error) {
    if (error.code() != ErrorCode::BadData) throw;
    cannot("surface_not_measured",
           "reference",
           error.what(),
           "check that both the mesh and the reference contain triangles or points");
}

// Returns the truth of the rig's body, whatever point the tracker followed.
types::Trajectory Measuring::true_body_path() const {
    const Eigen::Isometry3d T_marker_body = registered_.options.T_referencebody_estimatebody;
    types::Trajectory path = registered_.poses;
    for (types::StampedPose& pose : path) pose.T_world_imu = pose.T_world_imu * T_marker_body;
    return path;
}

// Returns the rig that the poses belong to; a result of an older version does not state it.
std::optional<types::Rig> Measuring::used_rig() const {
    if (auto rig = inputs_.reconstruction.rig()) return rig;
    if (!inputs_.dive) return std::nullopt;
    return markers::rig_as_scaled(inputs_.dive->rig(), inputs_.reconstruction.metrics());
}

void Measuring::measure_distances() {
    const std::optional<types::Rig> rig = used_rig();
    const bool all_marked = std::all_of(inputs_.known_distances.begin(),
                                        inputs_.known_distances.end(),
                                        [](const dive::KnownDistance& d) { return d.is_marked(); });
    // A reconstruction of the trajectory only has no keyframes in which the ends could be marked.
    const bool has_truth =
        result_.trajectory && inputs_.reference && !inputs_.reference->triangles.empty() &&
        inputs_.reconstruction.has_surface() && !registered_.options.pair_by_index;
    if (!rig || (!all_marked && !has_truth)) {
        cannot("known_distances_not_measured",
               "measurements.json",
               rig ? "not every known distance has its ends marked in the images"
                   : "lengths cannot be measured without the calibration of the rig, which is part "
                     "of the dive",
               rig ? "mark both ends in at least four frames (marks_a, marks_b), or give "
                     "ground truth, a reference mesh and a reconstruction with a surface"
                   : "give the dive too");
        return;
    }
    const types::Trajectory trajectory = inputs_.reconstruction.trajectory();
    const types::CovarianceTrack covariances = inputs_.reconstruction.covariances();
    const evaluation::KnownPath path{.trajectory = trajectory,
                                     .covariances = covariances,
                                     .scale_sigma = inputs_.reconstruction.scale_sigma(),
                                     .segments = inputs_.reconstruction.segments(),
                                     .contradiction_sigma = evaluation::contradiction_sigma(
                                         inputs_.reconstruction.scale_contradiction())};
    evaluation::KnownDistanceErrors errors;
    if (has_truth) {
        std::vector<std::int64_t> timestamps_ns;
        for (const io::KeyframePose& keyframe : inputs_.reconstruction.keyframes())
            timestamps_ns.push_back(keyframe.timestamp_ns);
        const types::Trajectory truth = evaluation::with_mounting_of(
            trajectory, true_body_path(), result_.trajectory->T_reference_estimate);
        const evaluation::SurfaceIndex reference(*inputs_.reference);
        const evaluation::MarkingInput marking{*rig, truth, timestamps_ns, reference};
        errors = evaluation::measure_known_distances(inputs_.known_distances, &marking, *rig, path);
    } else {
        errors = evaluation::measure_known_distances(inputs_.known_distances, nullptr, *rig, path);
    }
    result_.document["known_distances"] = evaluation::to_metrics(errors);
}

void Measuring::measure_reef() {
    reef::AreaSet areas = reef::read_areas(*request_.areas);
    if (!inputs_.reconstruction.has_surface()) {
        cannot("areas_not_measured",
               request_.areas->filename().string(),
               "the reconstruction has no surface",
               "reconstruct again with a surface");
        return;
    }
    if (areas.frame == reef::AreaFrame::GroundTruth) {
        if (!result_.trajectory) {
            cannot("areas_not_measured",
                   request_.areas->filename().string(),
                   "the areas are in the ground truth's frame, and there is no true trajectory",
                   "give the ground truth too");
            return;
        }
        areas = reef::moved(areas, result_.trajectory->T_reference_surface.inverse());
    }
    reef::MeasureOptions options = reef::measure_options(inputs_.reconstruction);
    options.num_threads = request_.num_threads;
    result_.reef = reef::measure_areas(
        evaluation::mesh_without_contradiction(inputs_.reconstruction), areas, options);
}

void add_distance_errors(json& document) {
    const json::json_pointer pointer("/known_distances/distances");
    if (!document.contains(pointer)) return;
    for (json& distance : document[pointer]) {
        const bool is_measured = distance.value("measured_m", json()).is_number();
        const double known_m = distance.at("known_m").get<double>();
        distance["error_m"] = nullptr;
        distance["error_percent"] = nullptr;
        if (!is_measured) continue;
        const double error_m = distance["measured_m"].get<double>() - known_m;
        distance["error_m"] = error_m;
        if (known_m > 0.0) distance["error_percent"] = 100.0 * error_m / known_m;
    }
}

}  // namespace

ReportMeasurements measure_for_report(const ReportInputs& inputs,
                                      const AccuracyReportRequest& request,
                                      const base::ProgressCallback& progress) {
    ReportMeasurements measured;
    Measuring(inputs, request, measured).measure(progress);
    add_distance_errors(measured.document);
    return measured;
}

}  // namespace divemesh::report
