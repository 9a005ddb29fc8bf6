#include "worker/simulator/diver_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "schemas/error.hpp"

namespace divemesh::simulator {
namespace {

constexpr double kStep_s = 1e-4;

SurveyPath straight_path() {
    SurveyPath path;
    path.straight = true;
    return path;
}

double polyline_m(const DiverMotion& motion, double duration_s) {
    double sum_m = 0.0;
    Eigen::Vector3d last = motion.at(0.0).T_world_imu.translation();
    for (double t_s = 0.01; t_s <= duration_s; t_s += 0.01) {
        const Eigen::Vector3d now = motion.at(t_s).T_world_imu.translation();
        sum_m += (now - last).norm();
        last = now;
    }
    return sum_m;
}

void expect_true_derivatives(const DiverMotion& motion) {
    for (double t_s = 0.0; t_s < 18.0; t_s += 0.7) {
        const MotionState before = motion.at(t_s - kStep_s);
        const MotionState now = motion.at(t_s);
        const MotionState after = motion.at(t_s + kStep_s);
        const Eigen::Vector3d velocity =
            (after.T_world_imu.translation() - before.T_world_imu.translation()) / (2.0 * kStep_s);
        const Eigen::Vector3d acceleration =
            (after.velocity_world - before.velocity_world) / (2.0 * kStep_s);
        EXPECT_LT((velocity - now.velocity_world).norm(), 1e-7);
        EXPECT_LT((acceleration - now.acceleration_world).norm(), 1e-6);
    }
}

void expect_true_turning(const DiverMotion& motion) {
    for (double t_s = 0.0; t_s < 18.0; t_s += 0.7) {
        const Eigen::Matrix3d R_before_after =
            motion.at(t_s - kStep_s).T_world_imu.linear().transpose() *
            motion.at(t_s + kStep_s).T_world_imu.linear();
        const Eigen::AngleAxisd turned(R_before_after);
        const Eigen::Vector3d rate = turned.angle() * turned.axis() / (2.0 * kStep_s);
        EXPECT_LT((rate - motion.at(t_s).angular_velocity_imu).norm(), 1e-6);
    }
}

TEST(DiverMotionTest, VelocityAndAccelerationAreTheDerivativesOfPosition) {
    expect_true_derivatives(DiverMotion::open_path({}, 5.0, 7));
    expect_true_derivatives(DiverMotion::open_path(straight_path(), 5.0, 7));
}

TEST(DiverMotionTest, AngularVelocityIsTheRateOfTheRotationInTheBody) {
    expect_true_turning(DiverMotion::open_path({}, 5.0, 8));
    expect_true_turning(DiverMotion::open_path(straight_path(), 5.0, 8));
}

TEST(DiverMotionTest, OpenPathHasTheLengthThatWasAsked) {
    const auto motion = DiverMotion::open_path({}, 12.5, 3);
    EXPECT_NEAR(polyline_m(motion, motion.duration_s()), 12.5, 0.01);
}

TEST(DiverMotionTest, StraightPathLeavesAlongXAndLooksThere) {
    const auto motion = DiverMotion::open_path(straight_path(), 50.0, 3);
    EXPECT_NEAR(polyline_m(motion, motion.duration_s()), 50.0, 0.05);
    const Eigen::Vector3d begin = motion.at(0.0).T_world_imu.translation();
    for (double t_s = 0.0; t_s <= motion.duration_s(); t_s += 1.0) {
        const MotionState state = motion.at(t_s);
        const Eigen::Vector3d swum = state.T_world_imu.translation() - begin;
        EXPECT_NEAR(swum.x(), straight_path().speed_m_s * t_s, 0.3);
        EXPECT_LT(swum.tail<2>().norm(), 0.4);
        const Eigen::Vector3d forward = state.T_world_imu.linear().col(0);
        EXPECT_LT(std::abs(std::atan2(forward.y(), forward.x())), 0.2);
    }
    EXPECT_GT(motion.at(motion.duration_s()).T_world_imu.translation().x(), 0.9 * 50.0);
}

TEST(DiverMotionTest, ClosedLapHasItsLengthAndRepeatsInPoseVelocityAndAcceleration) {
    const auto lap = DiverMotion::closed_lap({}, 9.0, 10.0, 4);
    const double lap_s = lap.duration_s();
    EXPECT_NEAR(polyline_m(lap, lap_s), 9.0, 0.01);
    EXPECT_NEAR(lap_s * 10.0, std::round(lap_s * 10.0), 1e-9);
    for (const double t_s : {0.0, 0.4 * lap_s, lap_s - 0.01}) {
        const MotionState first = lap.at(t_s);
        const MotionState second = lap.at(t_s + lap_s);
        EXPECT_TRUE(first.T_world_imu.isApprox(second.T_world_imu, 1e-9));
        EXPECT_LT((first.velocity_world - second.velocity_world).norm(), 1e-9);
        EXPECT_LT((first.acceleration_world - second.acceleration_world).norm(), 1e-9);
        EXPECT_LT((first.angular_velocity_imu - second.angular_velocity_imu).norm(), 1e-9);
    }
}

TEST(DiverMotionTest, PausedMotionHasTheDerivativesOfItsPositionToo) {
    const auto motion = DiverMotion::open_path({}, 5.0, 7).with_pauses({{0.0, 1.0}, {0.4, 2.0}});
    expect_true_derivatives(motion);
    expect_true_turning(motion);
    EXPECT_EQ(motion.at(0.5).velocity_world.norm(), 0.0);
    EXPECT_EQ(motion.at(0.5).acceleration_world.norm(), 0.0);
}

TEST(DiverMotionTest, StraightPathWithoutSwayIsUniform) {
    SurveyPath path = straight_path();
    path.sway = 0.0;
    const auto motion = DiverMotion::open_path(path, 10.0, 7);
    for (double t_s = 0.0; t_s < motion.duration_s(); t_s += 1.3) {
        EXPECT_NEAR(
            (motion.at(t_s).velocity_world - Eigen::Vector3d(path.speed_m_s, 0.0, 0.0)).norm(),
            0.0,
            1e-12);
        EXPECT_LT(motion.at(t_s).acceleration_world.norm(), 1e-12);
        EXPECT_LT(motion.at(t_s).angular_velocity_imu.norm(), 1e-12);
    }
}

TEST(DiverMotionTest, SwingReachesTheRateThatWasAskedAndTwentyDegrees) {
    SurveyPath path = straight_path();
    path.sway = 0.0;
    path.look_pitch = 0.0;
    path.swing_rad_s = 1.0;
    const auto motion = DiverMotion::open_path(path, 10.0, 7);
    double max_rate = 0.0;
    double max_yaw = 0.0;
    for (double t_s = 0.0; t_s < motion.duration_s(); t_s += 0.01) {
        const MotionState state = motion.at(t_s);
        max_rate = std::max(max_rate, state.angular_velocity_imu.norm());
        max_yaw = std::max(max_yaw, std::asin(state.T_world_imu.linear()(1, 0)));
    }
    EXPECT_NEAR(max_rate, 1.0, 1e-3);
    EXPECT_NEAR(max_yaw * 180.0 / 3.14159265, 20.0, 0.05);
}

TEST(DiverMotionTest, LapThatDoesNotFitTheSceneIsRefused) {
    EXPECT_THROW(DiverMotion::closed_lap({}, 500.0, 10.0, 4), Error);
    EXPECT_THROW(DiverMotion::closed_lap(straight_path(), 5.0, 10.0, 4), Error);
}

}  // namespace
}  // namespace divemesh::simulator
