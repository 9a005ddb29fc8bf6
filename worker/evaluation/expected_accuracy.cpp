#include "worker/evaluation/expected_accuracy.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/text.hpp"
#include "worker/evaluation/scaled_uncertainty.hpp"
#include "worker/optimisation/expected_path_error.hpp"

namespace divemesh::evaluation {
namespace {

using nlohmann::json;

constexpr double kLargeShareOfPath = 0.01;
constexpr double kLarge_m = 0.05;
constexpr double kEndOverAte = 3.0;  // of an error that grows along the path

void add_trajectory(const ExpectedAccuracyInput& input, ExpectedAccuracy& expected) {
    const auto leave_out = [&](const std::string& reason) {
        for (const char* metric : {"trajectory.end_position", "trajectory.ate"})
            expected.left_out.push_back({metric, reason});
    };
    if (input.covariances.empty() || !input.optimise.path.is_known())
        return leave_out("the dive had no bundle adjustment, so its poses have no covariance");
    if (input.num_segments > 1)
        return leave_out("the dive has " + std::to_string(input.num_segments) +
                         " segments whose positions relative to each other are not known");
    const types::LoopStatistics& loops = input.optimise.loops;
    const double scale = covariance_scale(loops);
    if (loops.num_accepted > 0) {
        expected.loop_residual_m = loops.residual_m;
        expected.covariance_scale = scale;
    } else {
        expected.left_out.push_back(
            {"trajectory.loops", "no place was recognised again, so the drift cannot be checked"});
    }
    types::PathUncertainty path = input.optimise.path;
    const Eigen::Vector3d by_scale_m = contradiction_sigma(path.scale_contradiction) *
                                       offsets_from_start(input.trajectory, {}).back();
    const Eigen::Matrix3d end_m2 =
        scale * scale * input.covariances.back().position_m2 + by_scale_m * by_scale_m.transpose();
    expected.end_expected_m = std::sqrt(end_m2.trace());
    expected.end_bound_m = std::sqrt(optimisation::squared_length_95(end_m2));
    path.mean_square_m2 *= scale * scale;
    path = covering_contradiction(path);
    expected.ate_bound_m =
        std::sqrt(optimisation::quantile_95(path.mean_square_m2, path.degrees_of_freedom));
    expected.ate_expected_m = std::sqrt(path.mean_square_m2);
}

std::string percent(double share) { return base::fixed(100.0 * share, 1) + " %"; }

// Returns what a source of lengths is called in a finding; "" for the markers, which have findings
// of their own (markers.json).
std::string words_for(const std::string& source) {
    if (source == "accelerometer") return "the accelerometer";
    if (source == "pressure") return "the pressure sensor";
    if (source == "known_distances") return "known distances";
    return "";
}

void find_contradiction(const ScaleSource& source, ExpectedAccuracy& expected) {
    const double off = source.check.scale - 1.0;
    const std::string words = words_for(source.name);
    if (words.empty()) return;
    expected.findings.push_back({Severity::Warning,
                                 "scale_contradicted",
                                 "",
                                 "lengths from " + words + " are " + percent(std::abs(off)) +
                                     (off > 0.0 ? " longer" : " shorter") +
                                     " than lengths from the cameras, more than " +
                                     "three times the expected error (standard deviation " +
                                     percent(source.check.sigma) + ")",
                                 "check the stereo calibration (baseline, focal length under "
                                 "water) and the units and noise of the sensor"});
}

void add_scale(const ExpectedAccuracyInput& input, ExpectedAccuracy& expected) {
    const types::PathUncertainty& path = input.optimise.path;
    if (path.scale_sigma > 0.0) expected.cameras = ScaleCheck{1.0, lengths_sigma(path)};
    expected.scales = against_path(input.scale.usable, path);
    for (const ScaleSource& source : expected.scales)
        if (is_contradicted(source.check)) find_contradiction(source, expected);
    expected.left_out.insert(
        expected.left_out.end(), input.scale.left_out.begin(), input.scale.left_out.end());
}

void add_residuals_of(const ExpectedAccuracyInput& input, ExpectedAccuracy& expected) {
    if (input.track.imu_vision_disagreement_deg > 0.0)  // 0: no IMU was used
        expected.imu_vision_disagreement_deg = input.track.imu_vision_disagreement_deg;
    else
        expected.left_out.push_back(
            {"imu_vision_disagreement_deg", "the dive has no IMU, or none is used"});
    if (input.optimise.reprojection_rms_px > 0.0)
        expected.reprojection_rms_px = input.optimise.reprojection_rms_px;
    else
        expected.left_out.push_back({"reprojection_rms_px", "the dive had no bundle adjustment"});
}

void add_surface(const ExpectedAccuracyInput& input, ExpectedAccuracy& expected) {
    if (input.mesh) expected.surface = expected_surface(*input.mesh);
    if (input.optimise.path.is_known())
        expected.surface_shared_m = optimisation::shared_sigma_m(input.optimise.path);
    if (expected.surface) return;
    expected.left_out.push_back(
        {"surface",
         input.mesh ? "the mesh is empty or without sigma" : "the reconstruction has no surface"});
}

void find_large_bounds(const ExpectedAccuracyInput& input, ExpectedAccuracy& expected) {
    if (!expected.end_bound_m) return;
    const double path_m = input.path_length_m;
    const double large_m = std::max(kLarge_m, kLargeShareOfPath * path_m);
    // A tilt of the first pose turns the whole path; only the rest of the error at the end is
    // drift.
    if (std::min(*expected.end_bound_m, kEndOverAte * *expected.ate_bound_m) <= large_m) return;
    expected.findings.push_back({Severity::Warning,
                                 "drift_may_be_large",
                                 "",
                                 "the position at the end may be off by up to " +
                                     base::fixed(*expected.end_bound_m, 2) + " m after " +
                                     base::fixed(path_m, 2) + " m of path (95 %)",
                                 "return to a place that you passed before, stay closer to "
                                 "textured ground, or place markers"});
}

}  // namespace

ExpectedAccuracy expected_accuracy(const ExpectedAccuracyInput& input) {
    ExpectedAccuracy expected;
    add_trajectory(input, expected);
    add_scale(input, expected);
    add_residuals_of(input, expected);
    add_surface(input, expected);
    find_large_bounds(input, expected);
    return expected;
}

json to_metrics(const ExpectedAccuracy& expected) {
    json result = {{"level", 0.95}, {"left_out", json::array()}};
    if (expected.end_bound_m)
        result["trajectory"] = {{"end_position",
                                 {{"bound_m", *expected.end_bound_m},
                                  {"expected_m", *expected.end_expected_m},
                                  {"relative_to", "first_pose"}}},
                                {"ate",
                                 {{"bound_m", *expected.ate_bound_m},
                                  {"expected_m", *expected.ate_expected_m},
                                  {"alignment", "se3"}}}};
    if (expected.loop_residual_m)
        result["trajectory"]["loops"] = {{"residual_rms_m", *expected.loop_residual_m},
                                         {"covariance_scale", *expected.covariance_scale}};
    if (expected.cameras) result["scale"]["cameras"] = to_metrics(*expected.cameras);
    for (const ScaleSource& source : expected.scales)
        result["scale"][source.name] = to_metrics(source.check);
    if (expected.imu_vision_disagreement_deg)
        result["imu_vision_disagreement_deg"] = *expected.imu_vision_disagreement_deg;
    if (expected.reprojection_rms_px) result["reprojection_rms_px"] = *expected.reprojection_rms_px;
    if (expected.surface) result["surface"] = to_metrics(*expected.surface);
    if (expected.surface && expected.surface_shared_m)
        result["surface"]["sigma_shared_m"] = *expected.surface_shared_m;
    for (const LeftOut& left_out : expected.left_out)
        result["left_out"].push_back({{"figure", left_out.metric}, {"reason", left_out.reason}});
    return result;
}

}  // namespace divemesh::evaluation
