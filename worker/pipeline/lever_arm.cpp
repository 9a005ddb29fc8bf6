#include "worker/pipeline/lever_arm.hpp"

#include <Eigen/Cholesky>

#include "worker/base/text.hpp"
#include "worker/evaluation/accelerometer_fit.hpp"
#include "worker/imu/estimate_alignment.hpp"
#include "worker/imu/usable_samples.hpp"

namespace divemesh::pipeline {
namespace {

constexpr double kSignificant = 5.5;        // sigmas
constexpr std::ptrdiff_t kMinWindows = 10;  // 11 s
constexpr double kMinLeverArm_m = 0.01;
constexpr double kMaxLeverArm_m = 0.5;  // of a rig that a diver holds
constexpr double kMaxSigma_m = 0.025;   // of an axis

double squared_sigmas(const Eigen::Vector3d& arm_m, const Eigen::Matrix3d& covariance_m2) {
    return arm_m.dot(covariance_m2.ldlt().solve(arm_m));
}

}  // namespace

std::optional<LeverArm> find_lever_arm(const types::OptimisedTrack& adjusted,
                                       const types::Recording& recording,
                                       const types::SensorsLeftOut& left_out) {
    if (!adjusted.breaks_ns.empty()) return std::nullopt;
    const auto fit = evaluation::fit_accelerometer(
        imu::aligned(imu::usable_forces(recording, left_out),
                     {adjusted.calibration.applied_alignment().time_offset_s}),
        adjusted.trajectory);
    if (!fit) return std::nullopt;
    LeverArm found;
    found.from_stated_m = adjusted.calibration.applied_lever_arm_m() + fit->lever_arm_m;
    found.sigma_m = fit->lever_arm_covariance_m2.diagonal().cwiseSqrt();
    found.is_significant = found.from_stated_m.norm() > kMinLeverArm_m &&
                           found.from_stated_m.norm() < kMaxLeverArm_m &&
                           found.sigma_m.maxCoeff() < kMaxSigma_m &&
                           fit->num_windows >= kMinWindows &&
                           squared_sigmas(found.from_stated_m, fit->lever_arm_covariance_m2) >
                               kSignificant * kSignificant;
    found.is_still = squared_sigmas(fit->lever_arm_m, fit->lever_arm_covariance_m2) < 3.0;
    return found;
}

std::optional<Finding> lever_arm_finding(const types::RefinedCalibration& calibration) {
    if (!calibration.lever_arm_applied) return std::nullopt;
    return Finding{Severity::Warning,
                   "imu_lever_arm",
                   "mav0/cam0/sensor.yaml",
                   "the IMU is " + base::fixed(100.0 * calibration.lever_arm_m.norm(), 1) + " +- " +
                       base::fixed(100.0 * calibration.lever_arm_sigma_m.norm(), 1) +
                       " cm from where the calibration (T_BS) says. The path is that of the IMU as "
                       "found",
                   "measure the position of the IMU relative to the left camera, and state it in "
                   "T_BS of both cameras"};
}

}  // namespace divemesh::pipeline
