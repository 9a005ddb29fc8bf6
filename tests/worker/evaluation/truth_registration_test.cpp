#include "worker/evaluation/truth_registration.hpp"

#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <random>
#include <string>

#include "schemas/error.hpp"
#include "worker/evaluation/trajectory_error.hpp"

namespace divemesh::evaluation {
namespace {

using Motion = std::function<Eigen::Isometry3d(double)>;

const Eigen::Vector3d kLever_m(0.12, -0.31, 0.25);
constexpr double kOffset_s = 3.217;

// Returns the pose of a swimmer: forward with surges, with roll, pitch and yaw at different
// frequencies.
Eigen::Isometry3d swim(double t) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(
        0.3 * t + 0.1 * std::sin(1.3 * t), 0.8 * std::sin(0.21 * t), 0.3 * std::sin(0.5 * t));
    pose.rotate(Eigen::AngleAxisd(0.6 * std::sin(0.4 * t + 0.2), Eigen::Vector3d::UnitZ()));
    pose.rotate(Eigen::AngleAxisd(0.3 * std::sin(0.9 * t), Eigen::Vector3d::UnitY()));
    pose.rotate(Eigen::AngleAxisd(0.25 * std::sin(0.73 * t + 1.0), Eigen::Vector3d::UnitX()));
    return pose;
}

// Returns a pose that only yaws.
Eigen::Isometry3d yaw(double t) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(0.3 * t, std::sin(0.4 * t), 0.0);
    pose.rotate(Eigen::AngleAxisd(0.6 * std::sin(0.5 * t), Eigen::Vector3d::UnitZ()));
    return pose;
}

Eigen::Isometry3d straight(double t) {
    return Eigen::Isometry3d(Eigen::Translation3d(0.3 * t, 0.0, 0.0));
}

Eigen::Isometry3d T_tracker_world() {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.rotate(Eigen::AngleAxisd(1.1, Eigen::Vector3d(0.2, 1, -0.4).normalized()));
    T.translation() = Eigen::Vector3d(20, -3, 7);
    return T;
}

Eigen::Isometry3d T_body_marker() {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = kLever_m;
    T.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
    return T;
}

// Returns the poses of the rig at 10 Hz for 60 s.
types::Trajectory estimate_of(const Motion& motion) {
    types::Trajectory trajectory;
    for (int i = 0; i < 600; ++i)
        trajectory.push_back({5'000'000'000 + i * std::int64_t{100'000'000}, motion(0.1 * i)});
    return trajectory;
}

// Returns the poses of a tracker at 50 Hz that follows the marker on its own clock, also before and
// after the dive.
types::Trajectory truth_of(const Motion& motion) {
    types::Trajectory trajectory;
    for (int i = -500; i < 3500; ++i) {
        const double t = 0.02 * i;
        trajectory.push_back({5'000'000'000 + std::llround((t + kOffset_s) * 1e9),
                              T_tracker_world() * motion(t) * T_body_marker()});
    }
    return trajectory;
}

types::Trajectory with_noise(types::Trajectory trajectory, double sigma_m, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, sigma_m);
    for (types::StampedPose& pose : trajectory)
        pose.T_world_imu.translation() +=
            Eigen::Vector3d(noise(random), noise(random), noise(random));
    return trajectory;
}

// Adds drift to a path: its errors accumulate.
types::Trajectory with_drift(types::Trajectory trajectory, double step_m, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, step_m);
    Eigen::Vector3d drift = Eigen::Vector3d::Zero();
    for (types::StampedPose& pose : trajectory) {
        drift += Eigen::Vector3d(noise(random), noise(random), noise(random));
        pose.T_world_imu.translation() += drift;
    }
    return trajectory;
}

TruthOptions solve_both() {
    TruthOptions options;
    options.solve_lever_arm = true;
    options.solve_time_offset = true;
    return options;
}

// Returns why the truth of a motion is not registered; empty if it is.
std::string refusal(const Motion& motion, const TruthOptions& options) {
    try {
        register_truth(estimate_of(motion), truth_of(motion), options);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::BadData);
        return error.what();
    }
    return "";
}

TEST(TruthRegistration, FindsLeverArmAxesAndOffsetOfAnExternalTracker) {
    const auto found = register_truth(estimate_of(swim), truth_of(swim), solve_both());
    EXPECT_NEAR(found.time_offset_s, kOffset_s, 2e-4);
    EXPECT_LT((found.T_body_marker.translation() - kLever_m).norm(), 1e-3);
    const Eigen::Matrix3d rotation =
        found.T_body_marker.linear().transpose() * T_body_marker().linear();
    EXPECT_LT(Eigen::AngleAxisd(rotation).angle(), 1e-3);
    EXPECT_TRUE(found.has_orientation);
    EXPECT_TRUE(found.outcome.converged()) << found.outcome.message;
    EXPECT_LT(found.outcome.final_cost, found.outcome.initial_cost);
}

TEST(TruthRegistration, TheErrorIsThatOfThePathAloneOnceTheTruthLiesRight) {
    const types::Trajectory estimate = estimate_of(swim);
    const auto truth = registered_truth(estimate, truth_of(swim), solve_both());
    const auto error = trajectory_error(estimate, truth.poses, truth.options);
    EXPECT_LT(error.ate_rmse_m, 1e-3);
    EXPECT_LT(error.rotation_rmse_deg, 0.1);
}

// Two standard deviations must hold in 95 % of many draws, i.e. in at least 36 of 40, for white
// errors and for drift.
TEST(TruthRegistration, StatedDeviationsHold) {
    const types::Trajectory truth = truth_of(swim);
    for (const bool drifts : {false, true}) {
        int num_offsets_held = 0;
        int num_levers_held = 0;
        constexpr int kNumDraws = 40;
        for (unsigned seed = 0; seed < kNumDraws; ++seed) {
            const types::Trajectory estimate = drifts ? with_drift(estimate_of(swim), 0.002, seed)
                                                      : with_noise(estimate_of(swim), 0.02, seed);
            const auto found = register_truth(estimate, truth, solve_both());
            ASSERT_TRUE(found.time_offset_sigma_s && found.lever_arm_sigma_m);
            EXPECT_TRUE(found.outcome.converged()) << found.outcome.num_iterations;
            num_offsets_held +=
                std::abs(found.time_offset_s - kOffset_s) < 2.0 * *found.time_offset_sigma_s;
            const Eigen::Vector3d off = found.T_body_marker.translation() - kLever_m;
            for (int axis = 0; axis < 3; ++axis)
                num_levers_held += std::abs(off[axis]) < 2.0 * (*found.lever_arm_sigma_m)[axis];
        }
        EXPECT_GE(num_offsets_held, 0.9 * kNumDraws) << "drifts: " << drifts;
        EXPECT_GE(num_levers_held, 0.9 * 3 * kNumDraws) << "drifts: " << drifts;
    }
}

TEST(TruthRegistration, ATrackerOfPositionsAloneGivesNoRotations) {
    types::Trajectory truth = truth_of(swim);
    for (types::StampedPose& pose : truth) pose.T_world_imu.linear().setIdentity();
    const types::Trajectory estimate = estimate_of(swim);
    const auto registered = registered_truth(estimate, truth, solve_both());
    EXPECT_FALSE(registered.registration.has_orientation);
    EXPECT_NEAR(registered.registration.time_offset_s, kOffset_s, 1e-3);
    const auto error = trajectory_error(estimate, registered.poses, registered.options);
    EXPECT_LT(error.ate_rmse_m, 2e-3);
    EXPECT_LT(error.drift_percent.value(), 0.5);
    const auto metrics = without_rotations(to_metrics(error));
    EXPECT_FALSE(metrics.contains("rotation_rmse_deg"));
}

TEST(TruthRegistration, RefusesALeverArmWhenTheRigTurnedAboutOneAxisAlone) {
    TruthOptions options;
    options.solve_lever_arm = true;
    options.time_offset_s = kOffset_s;
    EXPECT_THAT(refusal(yaw, options), testing::HasSubstr("lever arm cannot be solved"));
}

TEST(TruthRegistration, RefusesAnOffsetWhenTheVelocityNeverChanged) {
    TruthOptions options;
    options.solve_time_offset = true;
    EXPECT_THROW(register_truth(estimate_of(straight), truth_of(straight), options), Error);
}

// Returns a pose that is shaken faster than velocities are measured: their signs are wrong, so no
// step towards the offset of the clocks ends there.
Eigen::Isometry3d shaken(double t) {
    constexpr double kRate_rad_s = 4.2;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(0.1 * std::sin(5.0 * kRate_rad_s * t),
                                         0.1 * std::sin(5.3 * kRate_rad_s * t + 1.0),
                                         0.1 * std::sin(5.6 * kRate_rad_s * t + 2.0));
    return pose;
}

TEST(TruthRegistration, RefusesAnOffsetAtWhichIterationsDoNotEnd) {
    TruthOptions options;
    options.solve_time_offset = true;
    EXPECT_THAT(refusal(shaken, options), testing::HasSubstr("50 iterations did not suffice"));
}

TEST(TruthRegistration, WhatIsGivenIsTakenAsItIs) {
    TruthOptions options;
    const Eigen::Quaterniond q(T_body_marker().linear());
    options.lever_arm = {{kLever_m.x(), kLever_m.y(), kLever_m.z()}, {q.w(), q.x(), q.y(), q.z()}};
    options.time_offset_s = kOffset_s;
    const types::Trajectory estimate = estimate_of(swim);
    const auto truth = registered_truth(estimate, truth_of(swim), options);
    EXPECT_EQ(truth.registration.num_poses, 0);
    EXPECT_LT(trajectory_error(estimate, truth.poses, truth.options).ate_rmse_m, 1e-3);
}

}  // namespace
}  // namespace divemesh::evaluation
