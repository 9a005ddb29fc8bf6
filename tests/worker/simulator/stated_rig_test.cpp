#include "worker/simulator/stated_rig.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "worker/simulator/draw_rig.hpp"

namespace divemesh::simulator {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kNumDraws = 2000;

types::Rig rig() { return draw_rig(640, 480, 3); }

using Error = std::function<double(const types::Rig& truth, const StatedRig& stated)>;

// Returns the root mean square of an error over many draws.
double rms_of(const Error& error) {
    double sum = 0.0;
    for (int seed = 1; seed <= kNumDraws; ++seed) {
        const StatedRig stated = draw_calibration_error(rig(), 1.0, seed);
        sum += std::pow(error(rig(), stated), 2);
    }
    return std::sqrt(sum / kNumDraws);
}

Eigen::Vector3d rotation_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    const Eigen::AngleAxisd rotation(a.linear().transpose() * b.linear());
    return rotation.angle() * rotation.axis();
}

// The RMS of 2000 normal numbers differs from sigma by 1.6 %, one standard deviation.
void expect_rms(double sigma, const Error& error) { EXPECT_NEAR(rms_of(error) / sigma, 1.0, 0.07); }

TEST(StatedRigTest, DrawnErrorsOfTheLensesHaveTheStatedSize) {
    expect_rms(0.0015, [](const auto& truth, const auto& stated) {
        return stated.rig.cam0.fx_px / truth.cam0.fx_px - 1.0;
    });
    expect_rms(1.0, [](const auto& truth, const auto& stated) {
        return stated.rig.cam1.cy_px - truth.cam1.cy_px;
    });
    expect_rms(0.03, [](const auto& truth, const auto& stated) {
        return stated.rig.cam1.distortion_coefficients[0] / truth.cam1.distortion_coefficients[0] -
               1.0;
    });
}

TEST(StatedRigTest, DrawnErrorsBetweenCamerasAndImuHaveTheStatedSize) {
    for (const int axis : {0, 1, 2}) {
        expect_rms(0.03 * kDegree, [&](const auto& truth, const auto& stated) {
            return rotation_between(truth.T_cam1_cam0().inverse(),
                                    stated.rig.T_cam1_cam0().inverse())[axis];
        });
        expect_rms(0.25 * kDegree, [&](const auto& truth, const auto& stated) {
            return rotation_between(truth.T_imu_cam0, stated.rig.T_imu_cam0)[axis];
        });
    }
    expect_rms(0.002, [](const auto& truth, const auto& stated) {
        return stated.rig.baseline_m() / truth.baseline_m() - 1.0;
    });
    expect_rms(4e6, [](const auto&, const auto& stated) {
        return static_cast<double>(stated.imu_clock_offset_ns);
    });
}

TEST(StatedRigTest, SameSeedDrawsTheSameErrorsTwiceAsLargeForTwiceTheTimes) {
    const types::Rig truth = rig();
    const StatedRig once = draw_calibration_error(truth, 1.0, 9);
    const StatedRig again = draw_calibration_error(truth, 1.0, 9);
    const StatedRig twice = draw_calibration_error(truth, 2.0, 9);
    EXPECT_EQ(once.rig.cam0.fx_px, again.rig.cam0.fx_px);
    EXPECT_EQ(once.imu_clock_offset_ns, again.imu_clock_offset_ns);
    EXPECT_NEAR(twice.rig.cam0.cx_px - truth.cam0.cx_px,
                2.0 * (once.rig.cam0.cx_px - truth.cam0.cx_px),
                1e-9);
    EXPECT_NE(once.rig.cam0.fx_px, draw_calibration_error(truth, 1.0, 10).rig.cam0.fx_px);
}

TEST(StatedRigTest, NoErrorLeavesTheRigAsItIs) {
    const types::Rig truth = rig();
    const StatedRig stated = draw_calibration_error(truth, 0.0, 9);
    EXPECT_EQ(stated.imu_clock_offset_ns, 0);
    EXPECT_EQ(stated.rig.cam1.fy_px, truth.cam1.fy_px);
    EXPECT_TRUE(stated.rig.T_imu_cam1.isApprox(truth.T_imu_cam1, 1e-15));
}

// Rectified images show a point in one row if the calibration is right.
double rows_apart_px(const types::Rig& truth, const types::Rig& stated) {
    const Eigen::Vector3d p_cam0(0.03, -0.02, 2.0);
    const Eigen::Vector3d p_cam1 = truth.T_cam1_cam0() * p_cam0;
    const Eigen::Matrix3d R_truth_stated =
        truth.T_imu_cam1.linear().transpose() * stated.T_imu_cam1.linear();
    const Eigen::Vector3d seen = R_truth_stated.transpose() * p_cam1;
    return stated.cam1.fy_px * (seen.y() / seen.z() - p_cam1.y() / p_cam1.z());
}

TEST(StatedRigTest, PitchedCameraPutsTheImagesOutOfLineByTheStatedPixels) {
    const types::Rig truth = rig();
    for (const double misalignment_px : {0.5, 8.0})
        EXPECT_NEAR(std::abs(rows_apart_px(truth, pitch_right_camera(truth, misalignment_px))),
                    misalignment_px,
                    0.03 * misalignment_px);
}

}  // namespace
}  // namespace divemesh::simulator
