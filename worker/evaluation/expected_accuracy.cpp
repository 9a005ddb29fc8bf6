#include "worker/evaluation/expected_accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/base/text.hpp"
#include "worker/imu/estimate_alignment.hpp"
#include "worker/imu/usable_samples.hpp"
#include "worker/optimisation/expected_path_error.hpp"

namespace divemesh::evaluation {
namespace {

using nlohmann::json;

constexpr double kContradicts_sigmas = 3.0;
constexpr double kSigmasOf95 = 1.96;
constexpr double kMaxScaleSigma = 0.1;  // beyond it a check is not informative
constexpr double kLargeShareOfPath = 0.01;
constexpr double kLarge_m = 0.05;
constexpr double kEndOverAte = 3.0;  // of an error that grows along the path

// Returns the factor on standard deviations; 1 without loops, as there are no residuals then.
double covariance_scale(const types::LoopStatistics& loops) {
    return loops.num_accepted > 0 ? std::max(1.0, loops.residual_sigmas) : 1.0;
}

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
    const types::PathUncertainty& path = input.optimise.path;
    const Eigen::Matrix3d& end_m2 = input.covariances.back().position_m2;
    expected.end_expected_m = scale * std::sqrt(end_m2.trace());
    expected.end_bound_m = scale * std::sqrt(optimisation::squared_length_95(end_m2));
    expected.ate_bound_m =
        scale * std::sqrt(optimisation::quantile_95(path.mean_square_m2, path.degrees_of_freedom));
    expected.ate_expected_m = scale * std::sqrt(path.mean_square_m2);
}

std::string percent(double share) { return base::fixed(100.0 * share, 1) + " %"; }

// Returns the error of distant positions: they err independently, each by a third of the mean
// square along a line.
PathError path_error(const ExpectedAccuracyInput& input) {
    Eigen::AlignedBox3d box;
    for (const types::StampedPose& pose : input.trajectory)
        box.extend(pose.T_world_imu.translation());
    return {std::numbers::sqrt2 * optimisation::shared_sigma_m(input.optimise.path),
            box.isEmpty() ? 0.0 : box.diagonal().norm()};
}

// Returns an informative check, with the cameras' own error added to its sigma: 1 must be within
// it. A check that contradicts the cameras is reported as a finding.
std::optional<ScaleCheck> with_contradiction(std::optional<ScaleCheck> check,
                                             double cameras_sigma,
                                             const std::string& metric,
                                             const std::string& sensor,
                                             const std::string& why_not,
                                             ExpectedAccuracy& expected) {
    if (!check) {
        expected.left_out.push_back({metric, why_not});
        return std::nullopt;
    }
    check->sigma = std::hypot(check->sigma, cameras_sigma);
    if (check->sigma > kMaxScaleSigma) {
        expected.left_out.push_back({metric,
                                     "the motion determines too little: sigma would be " +
                                         percent(check->sigma) + " of the scale"});
        return std::nullopt;
    }
    const double off = check->scale - 1.0;
    if (std::abs(off) > kContradicts_sigmas * check->sigma) {
        expected.contradiction = std::max(expected.contradiction, std::abs(off));
        expected.findings.push_back({Severity::Warning,
                                     "scale_contradicted",
                                     "",
                                     "lengths from " + sensor + " are " + percent(std::abs(off)) +
                                         (off > 0.0 ? " longer" : " shorter") +
                                         " than lengths from the cameras, more than " +
                                         "three times the expected error (standard deviation " +
                                         percent(check->sigma) + ")",
                                     "check the stereo calibration (baseline, focal length under "
                                     "water) and the units and noise of the sensor"});
    }
    return check;
}

void add_scale(const ExpectedAccuracyInput& input, ExpectedAccuracy& expected) {
    const types::Recording& recording = input.recording;
    const double scale_sigma = input.optimise.path.scale_sigma;
    const double cameras_sigma = scale_sigma > 0.0 ? scale_sigma : kCalibrationSigma;
    if (scale_sigma > 0.0) expected.cameras = ScaleCheck{1.0, scale_sigma};
    if (input.num_segments > 1) {
        for (const char* metric : {"scale.accelerometer", "scale.pressure"})
            expected.left_out.push_back({metric, "the dive has several segments"});
    } else {
        const auto forces = imu::usable_forces(recording, input.sensors_left_out);
        expected.accelerometer = with_contradiction(
            scale_by_accelerometer(imu::aligned(forces, {input.imu_clock_offset_s}),
                                   input.trajectory),
            cameras_sigma,
            "scale.accelerometer",
            "the accelerometer",
            recording.imu().empty() ? "the dive has no IMU"
            : forces.empty()        ? "the accelerometer contradicts the images"
                                    : "the IMU covers too little of the dive without a gap",
            expected);
        expected.pressure = with_contradiction(
            scale_by_pressure(
                input.sensors_left_out.pressure ? std::vector<types::PressureSample>{}
                                                : recording.pressure(),
                input.trajectory,
                covariance_scale(input.optimise.loops) * input.optimise.path.vertical_scale_sigma),
            cameras_sigma,
            "scale.pressure",
            "the pressure sensor",
            recording.pressure().empty()      ? "the dive has no pressure sensor"
            : input.sensors_left_out.pressure ? "the pressure sensor contradicts the images"
                                              : "the pressure sensor covers too little of the dive",
            expected);
    }
    expected.known_distances = with_contradiction(
        input.known_distances ? scale_by_distances(*input.known_distances, path_error(input))
                              : std::nullopt,
        cameras_sigma,
        "scale.known_distances",
        "known distances",
        "fewer than three known distances could be measured",
        expected);
}

// Adds, where sensors contradict the scale of the cameras, what the positions would be off by if
// the sensors were right.
void cover_contradiction(const ExpectedAccuracyInput& input, ExpectedAccuracy& expected) {
    if (expected.contradiction <= 0.0) return;
    if (expected.cameras)
        expected.cameras->sigma =
            std::hypot(expected.cameras->sigma, expected.contradiction / kSigmasOf95);
    if (!expected.ate_bound_m || input.trajectory.empty()) return;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const types::StampedPose& pose : input.trajectory)
        centre += pose.T_world_imu.translation() / static_cast<double>(input.trajectory.size());
    double squares_m2 = 0.0;
    for (const types::StampedPose& pose : input.trajectory)
        squares_m2 += (pose.T_world_imu.translation() - centre).squaredNorm();
    const double spread_m = std::sqrt(squares_m2 / static_cast<double>(input.trajectory.size()));
    const double way_m = (input.trajectory.back().T_world_imu.translation() -
                          input.trajectory.front().T_world_imu.translation())
                             .norm();
    const auto add = [&](std::optional<double>& value_m, double length_m, double sigmas) {
        value_m = std::hypot(*value_m, expected.contradiction * length_m / sigmas);
    };
    add(expected.ate_bound_m, spread_m, 1.0);
    add(expected.ate_expected_m, spread_m, kSigmasOf95);
    add(expected.end_bound_m, way_m, 1.0);
    add(expected.end_expected_m, way_m, kSigmasOf95);
}

void add_residuals_of(const ExpectedAccuracyInput& input, ExpectedAccuracy& expected) {
    if (input.recording.rig().imu_noise)
        expected.imu_vision_disagreement_deg = input.track.imu_vision_disagreement_deg;
    else
        expected.left_out.push_back({"imu_vision_disagreement_deg", "the dive has no IMU"});
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
    cover_contradiction(input, expected);
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
    if (expected.accelerometer)
        result["scale"]["accelerometer"] = to_metrics(*expected.accelerometer);
    if (expected.pressure) result["scale"]["pressure"] = to_metrics(*expected.pressure);
    if (expected.known_distances)
        result["scale"]["known_distances"] = to_metrics(*expected.known_distances);
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
