#include "worker/pipeline/metrics_document.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <utility>

#include "schemas/content_hash.hpp"
#include "schemas/json.hpp"
#include "schemas/verdict.hpp"
#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/evaluation/scaled_uncertainty.hpp"
#include "worker/io/port_json.hpp"
#include "worker/io/rig_json.hpp"
#include "worker/io/solver_json.hpp"
#include "worker/pipeline/color_metrics.hpp"
#include "worker/pipeline/georeference_metrics.hpp"
#include "worker/types/disparity_range.hpp"

namespace divemesh::pipeline {
namespace {

using nlohmann::json;

double rate(std::int64_t count, double seconds) {
    return seconds > 0.0 ? static_cast<double>(count) / seconds : 0.0;
}

void append(std::string& text, double value) {
    char number[40];
    std::snprintf(number, sizeof number, "%.12g\n", value);
    text += number;
}

void append(std::string& text, const types::Camera& camera, const Eigen::Isometry3d& T_imu_cam) {
    for (const double value : {static_cast<double>(camera.width_px),
                               static_cast<double>(camera.height_px),
                               camera.fx_px,
                               camera.fy_px,
                               camera.cx_px,
                               camera.cy_px})
        append(text, value);
    text.append(io::to_string(camera.distortion)).append("\n");
    for (std::size_t i = 0; i < io::num_stated_coefficients(camera); ++i)
        append(text, camera.distortion_coefficients[i]);
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column) append(text, T_imu_cam(row, column));
    if (camera.port) text += io::to_json(*camera.port).dump();
}

// Returns a hash of the calibration's numbers, independent of the file they were read from.
std::string calibration_sha256(const types::Rig& rig) {
    std::string text;
    append(text, rig.cam0, rig.T_imu_cam0);
    append(text, rig.cam1, rig.T_imu_cam1);
    return sha256_hex(text);
}

json estimate(double value, double sigma) { return {{"value", value}, {"sigma", sigma}}; }

// Returns a refined camera: the stated values plus the estimated change, with sigmas.
json lens(const types::Camera& stated,
          const types::LensChange& change,
          const types::LensChange::Vector& sigmas) {
    const types::Camera camera = camera::changed_camera(stated, change);
    return {{"fx_px", estimate(camera.fx_px, sigmas[0] * stated.fx_px)},
            {"fy_px", estimate(camera.fy_px, sigmas[0] * stated.fy_px)},
            {"cx_px", estimate(camera.cx_px, sigmas[1])},
            {"cy_px", estimate(camera.cy_px, sigmas[2])},
            {"k1", estimate(camera.distortion_coefficients[0], sigmas[3])},
            {"k2", estimate(camera.distortion_coefficients[1], sigmas[4])}};
}

void add_lenses(const MetricsInput& input, json& result) {
    const types::RefinedCalibration& refined = input.refined;
    if (!refined.is_known()) return;
    result["lenses"] = {{"cam0", lens(input.rig.cam0, refined.lenses[0], refined.lens_sigmas[0])},
                        {"cam1", lens(input.rig.cam1, refined.lenses[1], refined.lens_sigmas[1])},
                        {"shift_px", refined.lens_shift_px},
                        {"applied", refined.lenses_applied}};
}

void add_readout_time(const types::RefinedCalibration& refined, json& result) {
    if (refined.readout_time_sigma_s <= 0.0) return;
    result["readout_time_s"] = {{"value", refined.readout_time_s},
                                {"sigma", refined.readout_time_sigma_s},
                                {"shift_px", refined.readout_shift_px},
                                {"applied", refined.readout_time_applied}};
}

void add_lever_arm(const types::RefinedCalibration& refined, json& result) {
    const Eigen::Vector3d& arm_m = refined.lever_arm_m;
    const Eigen::Vector3d& sigma_m = refined.lever_arm_sigma_m;
    if (sigma_m.isZero(0.0)) return;
    result["lever_arm_m"] = {{"vector", {arm_m.x(), arm_m.y(), arm_m.z()}},
                             {"sigma", {sigma_m.x(), sigma_m.y(), sigma_m.z()}},
                             {"applied", refined.lever_arm_applied}};
}

void add_imu(const MetricsInput& input, json& result) {
    const types::RefinedCalibration& refined = input.refined;
    if (!input.rig.imu_noise || refined.time_offset_sigma_s <= 0.0) return;
    const Eigen::Vector3d w = base::kDegPerRad * base::vector_from_rotation(refined.imu.q_body_imu);
    const Eigen::Vector3d sigma = base::kDegPerRad * refined.rotation_sigma_rad;
    result["time_offset_s"] = estimate(refined.imu.time_offset_s, refined.time_offset_sigma_s);
    result["time_offset_s"]["applied"] = refined.time_offset_applied;
    result["rotation_deg"] = {{"vector", {w.x(), w.y(), w.z()}},
                              {"sigma", {sigma.x(), sigma.y(), sigma.z()}},
                              {"angle", w.norm()},
                              {"applied", refined.rotation_applied}};
    const Eigen::Vector3d& error = refined.imu.rate_error;
    const Eigen::Vector3d& error_sigma = refined.rate_error_sigma;
    result["rate_error"] = {{"vector", {error.x(), error.y(), error.z()}},
                            {"sigma", {error_sigma.x(), error_sigma.y(), error_sigma.z()}},
                            {"applied", refined.rate_error_applied}};
    add_lever_arm(refined, result);
}

// Returns the parts of the calibration that were estimated; empty if none was.
json refined(const MetricsInput& input) {
    json result = json::object();
    add_lenses(input, result);
    add_readout_time(input.refined, result);
    add_imu(input, result);
    return result;
}

std::string_view to_string(types::RigAlignment::Outcome outcome) {
    using Outcome = types::RigAlignment::Outcome;
    switch (outcome) {
        case Outcome::Unknown: return "unknown";
        case Outcome::Inconsistent: return "inconsistent";
        case Outcome::AsStated: return "as_stated";
        case Outcome::Moved: return "moved";
    }
    return "";
}

// Returns what is known of the right camera's change; what the images do not tell is left out.
json rig_change(const types::RigChange::Vector& values, const types::RigChange::Vector& sigmas) {
    constexpr std::array<const char*, types::RigChange::kSize> kNames = {"pitch_deg",
                                                                         "yaw_deg",
                                                                         "roll_deg",
                                                                         "baseline_down_deg",
                                                                         "baseline_forward_deg",
                                                                         "focal",
                                                                         "centre_px",
                                                                         "centre_down_px"};
    json result = json::object();
    for (int i = 0; i < types::RigChange::kSize; ++i) {
        if (sigmas[i] <= 0.0) continue;
        const double unit = i < types::RigChange::kFocal ? base::kDegPerRad : 1.0;
        result[kNames[static_cast<std::size_t>(i)]] = estimate(unit * values[i], unit * sigmas[i]);
    }
    return result;
}

json rig_parts(const std::vector<types::RigPart>& parts) {
    json result = json::array();
    for (const types::RigPart& part : parts) {
        result.push_back({{"first_frame", part.first_frame},
                          {"num_frames", part.num_frames},
                          {"from_s", base::to_s(part.from_ns - parts[0].from_ns)},
                          {"found", part.found}});
        if (const json change = rig_change(part.values, part.sigmas); !change.empty())
            result.back()["change"] = change;
        if (part.shift_px > 0.0) result.back()["row_shift_px"] = part.shift_px;
    }
    return result;
}

// Returns the estimated position of the right camera. What the images do not tell is left out.
json alignment(const types::RigAlignment& found) {
    json result = {{"outcome", to_string(found.outcome)},
                   {"applied", found.applied},
                   {"num_pairs", found.num_pairs},
                   {"num_matches", found.num_matches},
                   {"num_inliers", found.num_inliers}};
    if (found.num_inliers == 0) return result;
    if (const json change = rig_change(found.change.values, found.sigmas); !change.empty())
        result["change"] = change;
    if (!found.parts.empty()) result["parts"] = rig_parts(found.parts);
    if (const types::MediumChange& medium = found.change.medium; !medium.is_none())
        result["medium"] = {{"focal_scale", medium.focal_scale},
                            {"refractive_index", medium.refractive_index}};
    result["row_shift_px"] = found.row_shift_px;
    result["row_error_px"] = found.row_error_px;
    result["pair_error_px"] = found.pair_error_px;
    result["num_windows"] = found.num_windows;
    if (found.disparity_bias_sigma_px > 0.0)
        result["disparity_bias_px"] =
            estimate(found.disparity_bias_px, found.disparity_bias_sigma_px);
    return result;
}

json dive(const MetricsInput& input) {
    json result = {{"name", input.dive_name},
                   {"content_sha256", input.content_sha256},
                   {"duration_s", input.duration_s}};
    if (const auto& position = input.position) {
        result["position"] = {{"latitude_deg", position->latitude_deg},
                              {"longitude_deg", position->longitude_deg}};
        if (position->x_azimuth_deg) result["position"]["x_azimuth_deg"] = *position->x_azimuth_deg;
    }
    return result;
}

json calibration(const MetricsInput& input) {
    const types::Rig& rig = input.rig;
    json result = {{"body_frame", rig.imu_noise ? "imu" : "cam0"},
                   {"baseline_m", rig.baseline_m()},
                   {"focal_px", {rig.cam0.fx_px, rig.cam0.fy_px}},
                   {"image_size_px", {rig.cam0.width_px, rig.cam0.height_px}},
                   {"distortion_model", io::to_string(rig.cam0.distortion)},
                   {"T_imu_cam0", io::to_json(rig.T_imu_cam0)},
                   {"sha256", calibration_sha256(input.stated_rig)},
                   {"alignment", alignment(input.alignment)},
                   {"rig", io::to_json(input.used_rig)},
                   {"scale_sigma", evaluation::lengths_sigma(input.optimise.path)}};
    if (const double contradiction = input.optimise.path.scale_contradiction; contradiction > 0.0)
        result["scale_contradiction"] = contradiction;
    if (input.gravity)
        result["gravity"] = {{"magnitude_m_s2", input.gravity->magnitude_m_s2},
                             {"tilt_deg", input.gravity->tilt_deg}};
    if (json estimated = refined(input); !estimated.empty())
        result["refined"] = std::move(estimated);
    if (input.scale_correction)
        result["scale_correction"] = evaluation::to_metrics(*input.scale_correction);
    return result;
}

json frames(const MetricsInput& input) {
    const types::TrackStatistics& track = input.track;
    json result = {
        {"num_frames", track.num_frames},
        {"num_skipped_frames", track.num_skipped_frames},
        {"num_frames_tracked", track.num_frames_tracked},
        {"num_frames_by_imu", input.num_frames_by_imu},
        {"num_frames_predicted", input.num_frames_predicted},
        {"num_degenerate_frames", track.num_degenerate_frames},
        {"coverage", rate(track.num_frames_tracked, static_cast<double>(track.num_frames))},
        {"num_keyframes", input.num_keyframes}};
    if (input.reduction > 1) result["reduction"] = input.reduction;
    return result;
}

json tracking(const MetricsInput& input) {
    const types::TrackStatistics& track = input.track;
    json result = {{"mean_tracked_features", track.mean_tracked_features},
                   {"inlier_share", track.inlier_share},
                   {"horn_scale_median", track.horn_scale_median},
                   {"median_depth_m", track.median_depth_m},
                   {"median_track_life_frames", track.median_track_life_frames},
                   {"num_landmarks", input.num_landmarks},
                   {"reprojection_rms_px", input.optimise.reprojection_rms_px}};
    if (track.imu_vision_disagreement_deg > 0.0)  // 0: no IMU was used
        result["imu_vision_disagreement_deg"] = track.imu_vision_disagreement_deg;
    return result;
}

json stereo(const types::SearchStatistics& dense) {
    const auto num_frames = static_cast<double>(dense.num_frames);
    json result = {{"num_frames", dense.num_frames},
                   {"mean_range_px", static_cast<double>(dense.sum_ranges_px) / num_frames}};
    const auto num_patches = static_cast<double>(dense.num_patches);
    if (dense.num_patches == 0) return result;
    result["clipped_share"] = rate(dense.num_too_far + dense.num_too_near, num_patches);
    result["too_near_share"] = rate(dense.num_too_near, num_patches);
    return result;
}

json segments(const std::vector<types::TrackingSegment>& segments) {
    json result = json::array();
    for (const types::TrackingSegment& segment : segments) {
        json intervals = json::array();
        for (const types::TrackingSegment::Interval& interval : segment.intervals)
            intervals.push_back({{"first_ns", interval.first_ns}, {"last_ns", interval.last_ns}});
        result.push_back({{"num_frames", segment.num_frames},
                          {"num_keyframes", segment.num_keyframes},
                          {"path_length_m", segment.path_length_m},
                          {"intervals", intervals}});
    }
    return result;
}

json loops(const types::LoopStatistics& loops) {
    json result = {{"num_candidates", loops.num_candidates},
                   {"num_matched", loops.num_matched},
                   {"num_accepted", loops.num_accepted},
                   {"num_rejected", loops.num_matched - loops.num_accepted},
                   {"largest_correction_m", nullptr}};
    if (loops.num_accepted > 0) result["largest_correction_m"] = loops.largest_correction_m;
    return result;
}

json estimation(const MetricsInput& input) {
    json solvers = json::object();
    const auto add = [&](const char* name, const types::SolverTally& tally) {
        if (tally.num_solves > 0) solvers[name] = io::to_json(tally);
    };
    add("alignment_rows", input.alignment.row_solver);
    add("alignment_ranges", input.alignment.range_solver);
    add("pose", input.track.pose_solver);
    add("window", input.track.window_solver);
    add("pose_graph", input.optimise.pose_graph);
    add("calibration", input.optimise.calibration);
    add("adjustment", input.optimise.bundle_adjustment);
    json result = {{"solvers", std::move(solvers)}};
    const types::TrackCheck& check = input.optimise.check;
    if (check.before.reprojection_rms_px <= 0.0) return result;  // nothing to check it against
    const auto agreement = [](const types::TrackAgreement& of) -> json {
        return {{"reprojection_rms_px", of.reprojection_rms_px},
                {"odometry_rms_sigmas", of.odometry_rms_sigmas}};
    };
    result["check"] = {{"before", agreement(check.before)},
                       {"after", agreement(check.after)},
                       {"moved_rms_sigmas", check.moved_rms_sigmas}};
    return result;
}

// Returns the speed. That of the whole run excludes the evaluation.
// It is left out if a stage was reused, as it would belong to another run.
json speed(const MetricsInput& input) {
    json stages = json::array();
    double wall_s = 0.0;
    double pipeline_s = 0.0;
    double cpu_s = 0.0;
    bool any_reused = false;
    for (const StageTime& stage : input.stages) {
        wall_s += stage.wall_s;
        cpu_s += stage.cpu_s;
        any_reused = any_reused || stage.reused;
        if (!stage.is_evaluation) pipeline_s += stage.wall_s;
        json entry = {{"stage", stage.stage},
                      {"wall_s", stage.wall_s},
                      {"cpu_s", stage.cpu_s},
                      {"reused", stage.reused}};
        if (!stage.reused) entry["frames_per_s"] = rate(input.track.num_frames, stage.wall_s);
        stages.push_back(std::move(entry));
    }
    json result = {{"wall_s", wall_s},
                   {"cpu_s", cpu_s},
                   {"stages", stages},
                   {"peak_memory_bytes", peak_memory_bytes()}};
    if (!any_reused) result["frames_per_s"] = rate(input.track.num_frames, pipeline_s);
    return result;
}

json texture(const TextureMetrics& metrics) {
    json result = {{"num_triangles", metrics.num_triangles},
                   {"error_rms_m", metrics.simplification.rms_m},
                   {"error_max_m", metrics.simplification.max_m},
                   {"num_atlases", metrics.num_atlases},
                   {"textured_share", metrics.textured_share},
                   {"texels_per_pixel", metrics.texels_per_pixel},
                   {"num_lost_images", metrics.lost_frames.size()}};
    if (metrics.mosaic_pixel_m > 0.0) result["mosaic_pixel_m"] = metrics.mosaic_pixel_m;
    return result;
}

json mesh(const MeshMetrics& metrics) {
    json result = {{"num_vertices", metrics.num_vertices},
                   {"num_triangles", metrics.num_triangles},
                   {"area_m2", metrics.area_m2},
                   {"num_holes", metrics.borders.num_holes},
                   {"hole_area_m2", metrics.borders.hole_area_m2},
                   {"largest_hole_m2", metrics.borders.largest_hole_m2},
                   {"outer_edge_m", metrics.borders.outer_edge_m},
                   {"small_components_m2", metrics.small_components_m2},
                   {"cut_by_sigma_m2", metrics.cut_by_sigma_m2},
                   {"voxel_m", metrics.voxels.median_m},
                   {"finest_voxel_m", metrics.voxels.finest_m},
                   {"coarsest_voxel_m", metrics.voxels.coarsest_m},
                   {"num_cloud_points", metrics.cloud.num_points},
                   {"cloud_spacing_m", metrics.cloud.spacing_m},
                   {"num_octree_points", metrics.cloud.num_octree_points},
                   {"octree_bytes", metrics.cloud.octree_bytes},
                   {"volume_memory_bytes", metrics.volume_memory_bytes}};
    if (!metrics.coverage.empty()) {
        result["covered_share"] = mesh::mean_covered_share(metrics.coverage);
        for (const mesh::ImageCoverage& image : metrics.coverage)
            result["covered_images"].push_back(
                {{"timestamp_ns", image.timestamp_ns},
                 {"share", image.covered_share},
                 {"matched_share", image.matched_share},
                 {"covered_matched_share", image.covered_matched_share}});
    }
    if (const auto share = mesh::covered_share_of_matched(metrics.coverage))
        result["covered_share_of_matched"] = *share;
    if (metrics.simplification)
        result["simplification"] = {
            {"num_triangles_before", metrics.simplification->num_triangles_before},
            {"rms_m", metrics.simplification->rms_m},
            {"max_m", metrics.simplification->max_m}};
    return result;
}

void add_evaluation(const evaluation::Evaluation& evaluation, json& document) {
    json& trajectory = document["trajectory"];
    if (evaluation.trajectory) trajectory["final"] = to_metrics(*evaluation.trajectory);
    if (evaluation.covariance)
        trajectory["covariance"]["check"] = to_metrics(*evaluation.covariance);
    if (evaluation.causal) trajectory["causal"] = to_metrics(*evaluation.causal);
    if (evaluation.surface) document["surface"] = to_metrics(*evaluation.surface);
    if (evaluation.known_distances)
        document["known_distances"] = to_metrics(*evaluation.known_distances);
}

// Returns a finding if part of the scene was closer than the max searched disparity: it is missing
// in the model.
std::optional<Finding> find_too_near(const MetricsInput& input) {
    constexpr double kTolerated = 0.02;
    const types::SearchStatistics& dense = input.track.dense;
    if (dense.num_patches == 0) return std::nullopt;
    const double share =
        static_cast<double>(dense.num_too_near) / static_cast<double>(dense.num_patches);
    if (share <= kTolerated) return std::nullopt;
    int searched_px = input.options.num_disparities_px;
    if (input.options.stereo == "sgm")
        searched_px =
            types::max_disparities_px(searched_px, input.rig.cam0.width_px / input.reduction);
    const std::string again = searched_px < types::kMaxDisparities
                                  ? "reconstruct again with a larger num_disparities_px, and "
                                  : "";
    return Finding{Severity::Warning,
                   "scene_too_near",
                   "",
                   base::fixed(100.0 * share, 0) +
                       " % of the scene was too close for the disparity search range (" +
                       std::to_string(searched_px) + " px) and is missing from the mesh",
                   again + "keep more distance on the next dive"};
}

}  // namespace

json metrics_document(const MetricsInput& input) {
    json document = {{"format", 1},
                     {"version", input.version},
                     {"preset", input.preset},
                     {"options", options_to_json(input.options)},
                     {"dive", dive(input)},
                     {"calibration", calibration(input)},
                     {"frames", frames(input)},
                     {"tracking", tracking(input)},
                     {"trajectory", {{"path_length_m", input.path_length_m}}},
                     {"loops", loops(input.optimise.loops)},
                     {"pieces", segments(input.segments)},
                     {"estimation", estimation(input)},
                     {"speed", speed(input)}};
    document["trajectory"]["vertical_known"] = input.vertical_is_known;
    if (input.track.dense.num_frames > 0) document["stereo"] = stereo(input.track.dense);
    if (input.mesh) document["mesh"] = mesh(*input.mesh);
    if (input.texture) document["texture"] = texture(*input.texture);
    if (input.color) document["color"] = to_metrics(*input.color);
    if (input.georeference) document["georeference"] = to_metrics(*input.georeference);
    if (input.end_covariance_m2)
        document["trajectory"]["covariance"]["end_sigma_m"] =
            std::sqrt(input.end_covariance_m2->trace());
    add_evaluation(input.evaluation, document);
    std::vector<Finding> findings = input.findings;
    findings.insert(
        findings.end(), input.evaluation.findings.begin(), input.evaluation.findings.end());
    if (input.markers) {
        document["markers"] = to_metrics(*input.markers);
        const std::vector<Finding>& of_markers = input.markers->findings;
        findings.insert(findings.end(), of_markers.begin(), of_markers.end());
    }
    if (input.expected) {
        document["expected_accuracy"] = to_metrics(*input.expected);
        findings.insert(
            findings.end(), input.expected->findings.begin(), input.expected->findings.end());
    }
    if (const auto too_near = find_too_near(input)) findings.push_back(*too_near);
    document["findings"] = findings;
    document["verdict"] = to_string(verdict_on(findings));
    document["restrictions"] = restrictions_of(findings);
    return document;
}

// The peak of this program's own memory; getrusage would include what ran before exec.
std::int64_t peak_memory_bytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        if (!line.starts_with("VmHWM:")) continue;
        std::istringstream words(line.substr(6));
        std::int64_t num_kib = 0;
        words >> num_kib;
        return num_kib * 1024;
    }
    return 0;
}

}  // namespace divemesh::pipeline
