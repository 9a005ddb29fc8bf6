#include "worker/calibration/calibration_uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "worker/base/rotation_vector.hpp"
#include "worker/calibration/calibration_priors.hpp"
#include "worker/camera/rectified_lens.hpp"

namespace divemesh::calibration {
namespace {

constexpr int kLenses = 0;
constexpr int kStereo = kLenses + LensReprojection::kNumChanges;  // pitch, yaw, roll of the right
constexpr int kBaseline = kStereo + 3;
constexpr int kImu = kBaseline + 1;  // rotation about the axes of the IMU
constexpr int kLeverArm = kImu + 3;
constexpr int kSize = kLeverArm + 3;
constexpr double kTypicalDisparity_px = 20.0;
// The typical error of a distortion, as a share of its prior: that is wide enough to find one that
// is far off.
constexpr double kTypicalDistortion = 0.33;
// Standard deviations of the scale, relative: the first behind a port that no calibration in water
// has measured, the second with a calibration in the wrong medium.
constexpr double kMediumSigma = 0.01;
constexpr double kWrongMediumSigma = 0.25;
constexpr double kBiasSigmas = 2.0;  // ranges are not independent of each other
using Shift = Eigen::Matrix<double, 3, kSize>;
using LensShift = Eigen::Matrix<double, 2, types::LensChange::kSize>;

// How far changes of a lens move the rectified image. They vary slowly over it, so that the nearest
// point of a grid is close enough.
class LensShifts {
public:
    LensShifts(const types::RectifiedRig& rig, const camera::RectifiedLens& lens)
        : step_u_px_(static_cast<double>(rig.width_px) / kSteps),
          step_v_px_(static_cast<double>(rig.height_px) / kSteps) {
        for (int row = 0; row <= kSteps; ++row)
            for (int column = 0; column <= kSteps; ++column) {
                shifts_.push_back(camera::shift_of_change(
                    rig, lens, Eigen::Vector2d(column * step_u_px_, row * step_v_px_)));
                // Where the lens cannot be inverted, no feature is.
                if (!shifts_.back().allFinite()) shifts_.back().setZero();
            }
    }

    const LensShift& at(double u_px, double v_px) const {
        const auto nearest = [](double steps) {
            return static_cast<std::size_t>(
                std::lround(std::clamp(steps, 0.0, static_cast<double>(kSteps))));
        };
        return shifts_[nearest(v_px / step_v_px_) * (kSteps + 1) + nearest(u_px / step_u_px_)];
    }

private:
    static constexpr int kSteps = 32;
    double step_u_px_;
    double step_v_px_;
    std::vector<LensShift> shifts_;
};

// The derivative of a measurement with respect to the errors of the calibration.
class CalibrationShifts {
public:
    CalibrationShifts(const types::Rig& rig, const types::RectifiedRig& rectified)
        : rig_(rectified),
          left_(rectified, camera::rectified_lenses(rig)[0]),
          right_(rectified, camera::rectified_lenses(rig)[1]) {}

    Eigen::Matrix3Xd of(const Eigen::Vector3d& measured_px) const {
        Shift shift = Shift::Zero();
        constexpr int kLens = types::LensChange::kSize;
        shift.block<2, kLens>(0, kLenses) = left_.at(measured_px.x(), measured_px.y());
        if (measured_px.z() <= 0.0) return shift;
        const double right_px = measured_px.x() - measured_px.z();
        shift.block<1, kLens>(2, kLenses) = shift.block<1, kLens>(0, kLenses);
        shift.block<1, kLens>(2, kLenses + kLens) = -right_.at(right_px, measured_px.y()).row(0);
        shift.block<1, 3>(2, kStereo) = by_rotation(right_px, measured_px.y());
        shift(2, kBaseline) = measured_px.z();
        shift.block<3, 6>(0, kImu) = by_mounting(measured_px);
        return shift;
    }

private:
    // Returns how far a rotation of the right camera moves its column.
    Eigen::RowVector3d by_rotation(double right_px, double v_px) const {
        const double x = (right_px - rig_.cx_px) / rig_.focal_px;
        const double y = (v_px - rig_.cy_px) / rig_.focal_px;
        return rig_.focal_px * Eigen::RowVector3d(-x * y, 1.0 + x * x, -y);
    }
    // Returns how far rotation and translation of both cameras against the IMU move (u, v,
    // disparity).
    Eigen::Matrix<double, 3, 6> by_mounting(const Eigen::Vector3d& measured_px) const {
        const double depth_m = rig_.depth_m(measured_px.z());
        const Eigen::Vector3d p = rig_.point_cam(measured_px.x(), measured_px.y(), depth_m);
        const double scale = rig_.focal_px / p.z();
        Eigen::Matrix3d by_point;
        by_point << scale, 0.0, -scale * p.x() / p.z(),  //
            0.0, scale, -scale * p.y() / p.z(),          //
            0.0, 0.0, -scale * rig_.baseline_m / p.z();
        const Eigen::Matrix3d R_cam_imu = rig_.T_imu_cam.linear().transpose();
        Eigen::Matrix<double, 3, 6> result;
        result << by_point * base::cross_matrix(p) * R_cam_imu, -by_point * R_cam_imu;
        return result;
    }

    types::RectifiedRig rig_;
    LensShifts left_;
    LensShifts right_;
};

// Returns true if the right camera's pose was estimated and is used as estimated.
bool is_aligned(const types::RigAlignment& alignment) {
    using Outcome = types::RigAlignment::Outcome;
    return alignment.outcome == Outcome::AsStated ||
           (alignment.outcome == Outcome::Moved && alignment.applied);
}

// Returns the prior of the lenses, given what ranges determined of the disparities in the centre.
LensCovariance without_refinement(const types::Rig& rig,
                                  const Eigen::Matrix3Xd& shift_in_centre,
                                  const types::RigAlignment& alignment) {
    LensChanges sigmas = lens_prior_sigmas(rig, alignment);
    for (const int lens : {0, types::LensChange::kSize})
        for (const int coefficient : {types::LensChange::kK1, types::LensChange::kK2})
            sigmas[lens + coefficient] *= kTypicalDistortion;
    LensCovariance prior = sigmas.cwiseAbs2().asDiagonal();
    if (alignment.disparity_bias_sigma_px <= 0.0 || !is_aligned(alignment)) return prior;
    const double left_px =
        alignment.applied && alignment.moves_disparities() ? 0.0 : alignment.disparity_bias_px;
    const double sigma_px = std::hypot(kBiasSigmas * alignment.disparity_bias_sigma_px, left_px);
    const LensChanges bias = shift_in_centre.row(2).head<LensReprojection::kNumChanges>();
    const LensChanges gain = prior * bias;
    return prior - gain * gain.transpose() / (bias.dot(gain) + sigma_px * sigma_px);
}

LensCovariance of_lenses(const CalibrationRefinement& refined) {
    const types::RefinedCalibration& calibration = refined.calibration;
    LensChanges left_out = joined(calibration.lenses);
    if (calibration.lenses_applied) left_out -= joined(calibration.lenses);
    return refined.lens_covariance + left_out * left_out.transpose();
}

Eigen::Matrix3d of_imu_rotation(const types::Rig& rig,
                                const types::RefinedCalibration& calibration) {
    if (!rig.imu_noise) return Eigen::Matrix3d::Zero();  // the body is the camera
    if (calibration.rotation_sigma_rad.isZero())
        return kImuRotationSigma_rad * kImuRotationSigma_rad * Eigen::Matrix3d::Identity();
    Eigen::Vector3d left_out = Eigen::Vector3d::Zero();
    if (!calibration.rotation_applied)
        left_out = base::vector_from_rotation(calibration.imu.q_body_imu);
    return Eigen::Matrix3d(calibration.rotation_sigma_rad.cwiseAbs2().asDiagonal()) +
           left_out * left_out.transpose();
}

Eigen::Matrix3d of_rate_error(const types::Rig& rig, const types::RefinedCalibration& calibration) {
    if (!rig.imu_noise) return Eigen::Matrix3d::Zero();
    if (calibration.rate_error_sigma.isZero())
        return kRateErrorSigma * kRateErrorSigma * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d left_out =
        calibration.imu.rate_error - calibration.applied_alignment().rate_error;
    return Eigen::Matrix3d(calibration.rate_error_sigma.cwiseAbs2().asDiagonal()) +
           left_out * left_out.transpose();
}

Eigen::Matrix3d of_lever_arm(const types::Rig& rig, const types::RefinedCalibration& calibration) {
    if (!rig.imu_noise) return Eigen::Matrix3d::Zero();
    if (!calibration.lever_arm_applied)
        return kLeverArmSigma_m * kLeverArmSigma_m * Eigen::Matrix3d::Identity();
    return calibration.lever_arm_sigma_m.cwiseAbs2().asDiagonal();
}

double of_medium(const types::RigAlignment& alignment) {
    if (alignment.change.medium.is_none()) return 0.0;
    return alignment.applied ? kMediumSigma : kWrongMediumSigma;
}

double of_time_offset(const types::Rig& rig, const types::RefinedCalibration& calibration) {
    if (!rig.imu_noise) return 0.0;
    if (calibration.time_offset_sigma_s <= 0.0) return kTimeOffsetSigma_s;
    return std::hypot(
        calibration.time_offset_sigma_s,
        calibration.imu.time_offset_s - calibration.applied_alignment().time_offset_s);
}

}  // namespace

optimisation::CalibrationUncertainty calibration_uncertainty(const types::Rig& rig,
                                                             const types::RectifiedRig& rectified,
                                                             const CalibrationRefinement& refined,
                                                             const types::RigAlignment& alignment) {
    optimisation::CalibrationUncertainty result;
    const auto shifts = std::make_shared<const CalibrationShifts>(rig, rectified);
    result.shift_px = [shifts](const Eigen::Vector3d& measured_px) {
        return shifts->of(measured_px);
    };
    result.covariance = Eigen::MatrixXd::Zero(kSize, kSize);
    const Eigen::Vector3d centre_px(rectified.cx_px, rectified.cy_px, kTypicalDisparity_px);
    result.covariance.block<LensReprojection::kNumChanges, LensReprojection::kNumChanges>(
        kLenses, kLenses) = refined.calibration.is_known()
                                ? of_lenses(refined)
                                : without_refinement(rig, shifts->of(centre_px), alignment);
    const double rotation_sigma =
        is_aligned(alignment) ? kAlignedRotationSigma : kStereoRotationSigma;
    for (const int axis : {0, 2})
        result.covariance(kStereo + axis, kStereo + axis) = rotation_sigma * rotation_sigma;
    result.covariance(kBaseline, kBaseline) = std::pow(kBaselineSigma, 2) +
                                              std::pow(rig.right_delay_baseline_sigma, 2) +
                                              std::pow(of_medium(alignment), 2);
    result.covariance.block<3, 3>(kImu, kImu) = of_imu_rotation(rig, refined.calibration);
    result.covariance.block<3, 3>(kLeverArm, kLeverArm) = of_lever_arm(rig, refined.calibration);
    result.time_offset_sigma_s = of_time_offset(rig, refined.calibration);
    result.rate_error_covariance = of_rate_error(rig, refined.calibration);
    return result;
}

}  // namespace divemesh::calibration
