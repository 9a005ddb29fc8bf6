#include "worker/calibration/calibration_uncertainty.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "worker/camera/rectifier.hpp"

namespace divemesh::calibration {
namespace {

// Columns of CalibrationUncertainty, see calibration_uncertainty.cpp.
constexpr int kStereo = 10;
constexpr int kBaseline = 13;
constexpr int kImu = 14;
constexpr int kLeverArm = 17;
constexpr double kStep = 1e-5;

types::Rig rig() {
    types::Rig rig;
    rig.cam0.width_px = rig.cam1.width_px = 640;
    rig.cam0.height_px = rig.cam1.height_px = 480;
    for (types::Camera* camera : {&rig.cam0, &rig.cam1}) {
        camera->fx_px = camera->fy_px = 500.0;
        camera->cx_px = 319.5;
        camera->cy_px = 239.5;
    }
    rig.T_imu_cam0.linear() =
        Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d(1.0, 2.0, -1.0).normalized())
            .toRotationMatrix();
    rig.T_imu_cam1 = rig.T_imu_cam0 * Eigen::Translation3d(0.12, 0.0, 0.0);
    rig.imu_noise = types::ImuNoise{};
    return rig;
}

class CalibrationUncertaintyTest : public testing::Test {
protected:
    CalibrationUncertaintyTest()
        : rectified_(camera::Rectifier(rig()).rig()),
          uncertainty_(calibration_uncertainty(rig(), rectified_, {}, {})) {}

    // Returns (u, v, disparity) of a point on the body.
    static Eigen::Vector3d measured_px(const types::RectifiedRig& rig,
                                       const Eigen::Vector3d& p_imu) {
        const Eigen::Vector3d p_cam = rig.T_imu_cam.inverse() * p_imu;
        const Eigen::Vector2d pixel = rig.pixel(p_cam);
        return {pixel.x(), pixel.y(), rig.disparity_px(p_cam.z())};
    }

    types::RectifiedRig rectified_;
    optimisation::CalibrationUncertainty uncertainty_;
    Eigen::Vector3d p_imu_ = rectified_.T_imu_cam * Eigen::Vector3d(0.4, -0.3, 2.0);
};

TEST_F(CalibrationUncertaintyTest, TheMountingMovesWhatTheCamerasSee) {
    const Eigen::Vector3d before = measured_px(rectified_, p_imu_);
    const Eigen::Matrix3Xd shift = uncertainty_.shift_px(before);
    for (int axis = 0; axis < 3; ++axis) {
        types::RectifiedRig turned = rectified_;
        turned.T_imu_cam.linear() =
            Eigen::AngleAxisd(kStep, Eigen::Vector3d::Unit(axis)) * rectified_.T_imu_cam.linear();
        const Eigen::Vector3d by_turn = (measured_px(turned, p_imu_) - before) / kStep;
        EXPECT_LT((by_turn - shift.col(kImu + axis)).norm(), 0.05) << axis;

        types::RectifiedRig moved = rectified_;
        moved.T_imu_cam.translation() += kStep * Eigen::Vector3d::Unit(axis);
        const Eigen::Vector3d by_move = (measured_px(moved, p_imu_) - before) / kStep;
        EXPECT_LT((by_move - shift.col(kLeverArm + axis)).norm(), 0.05) << axis;
    }
}

TEST_F(CalibrationUncertaintyTest, TheRightCameraMovesDisparities) {
    const Eigen::Vector3d before = measured_px(rectified_, p_imu_);
    const Eigen::Matrix3Xd shift = uncertainty_.shift_px(before);
    const Eigen::Vector3d p_right =
        rectified_.T_imu_cam.inverse() * p_imu_ - Eigen::Vector3d(rectified_.baseline_m, 0.0, 0.0);
    for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d turned =
            Eigen::AngleAxisd(-kStep, Eigen::Vector3d::Unit(axis)) * p_right;
        const double moved_px =
            (rectified_.pixel(turned).x() - rectified_.pixel(p_right).x()) / kStep;
        EXPECT_NEAR(shift(2, kStereo + axis), -moved_px, 0.05) << axis;
    }
    EXPECT_DOUBLE_EQ(shift(2, kBaseline), before.z());
}

// A rig that moves by 1 % of its baseline in the standard deviation of the delay between its
// images.
TEST_F(CalibrationUncertaintyTest, AnUncertainDelayIsAnUncertainBaseline) {
    types::Rig late = rig();
    late.right_delay_baseline_sigma = 0.01;
    const auto variance = [&](const types::Rig& of) {
        return calibration_uncertainty(of, rectified_, {}, {}).covariance(kBaseline, kBaseline);
    };
    EXPECT_NEAR(variance(late) - variance(rig()), 1e-4, 1e-12);
}

// In water a calibration in air makes depths a quarter too small; a port that is taken into account
// has not been measured.
TEST_F(CalibrationUncertaintyTest, AnotherMediumMakesTheScaleUncertain) {
    types::RigAlignment alignment;
    const auto variance = [&] {
        return calibration_uncertainty(rig(), rectified_, {}, alignment)
            .covariance(kBaseline, kBaseline);
    };
    const double without = variance();
    alignment.change.medium.refractive_index = 1.337;
    EXPECT_NEAR(variance() - without, 0.25 * 0.25, 1e-12);
    alignment.applied = true;
    EXPECT_NEAR(variance() - without, 1e-4, 1e-12);
}

TEST_F(CalibrationUncertaintyTest, RangesNarrowTheBiasOfDisparities) {
    types::RigAlignment alignment;
    alignment.outcome = types::RigAlignment::Outcome::AsStated;
    alignment.disparity_bias_sigma_px = 0.05;
    const Eigen::Vector3d centre_px(rectified_.cx_px, rectified_.cy_px, 20.0);
    const auto bias_sigma_px = [&](const types::RigAlignment& found) {
        const auto uncertainty = calibration_uncertainty(rig(), rectified_, {}, found);
        const Eigen::RowVectorXd bias = uncertainty.shift_px(centre_px).row(2).head(kStereo);
        return std::sqrt(
            (bias * uncertainty.covariance.topLeftCorner(kStereo, kStereo) * bias.transpose())(0));
    };
    EXPECT_NEAR(bias_sigma_px({}), std::sqrt(1.0 + 1.0 + 0.25 * 0.25), 0.05);
    EXPECT_NEAR(bias_sigma_px(alignment), 0.1, 0.005);
}

TEST_F(CalibrationUncertaintyTest, WhatWasEstimatedButNotAppliedIsPartOfTheError) {
    CalibrationRefinement refined;
    refined.lens_covariance = 1e-8 * LensCovariance::Identity();
    refined.calibration.lens_sigmas.fill(types::LensChange::Vector::Constant(1e-4));
    refined.calibration.lenses[0].values[0] = 1e-3;
    EXPECT_NEAR(calibration_uncertainty(rig(), rectified_, refined, {}).covariance(0, 0),
                1e-6 + 1e-8,
                1e-12);
    refined.calibration.lenses_applied = true;
    EXPECT_NEAR(
        calibration_uncertainty(rig(), rectified_, refined, {}).covariance(0, 0), 1e-8, 1e-12);
}

// Rates that are 0.4 % too large about z are not corrected: the focal length may be the cause.
TEST_F(CalibrationUncertaintyTest, AnErrorOfTheRatesThatIsNotAppliedIsPartOfTheirError) {
    CalibrationRefinement refined;
    refined.calibration.imu.rate_error.z() = 0.004;
    refined.calibration.rate_error_sigma.setConstant(1e-3);
    const auto variances = [&](const types::Rig& of) -> Eigen::Vector3d {
        return calibration_uncertainty(of, rectified_, refined, {})
            .rate_error_covariance.diagonal();
    };
    EXPECT_TRUE(variances(rig()).isApprox(Eigen::Vector3d(1e-6, 1e-6, 17e-6)));
    refined.calibration.rate_error_applied = true;
    EXPECT_TRUE(variances(rig()).isApprox(Eigen::Vector3d(1e-6, 1e-6, 1e-6)));
    types::Rig without_imu = rig();
    without_imu.imu_noise.reset();
    EXPECT_TRUE(variances(without_imu).isZero());
}

}  // namespace
}  // namespace divemesh::calibration
