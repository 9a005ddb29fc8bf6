#include "worker/evaluation/trajectory_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "schemas/error.hpp"
#include "tests/paths.hpp"
#include "worker/evaluation/evaluate.hpp"

namespace divemesh::evaluation {
namespace {

constexpr std::int64_t kFrame_ns = 100'000'000;

// The pose of the body as a function of time in seconds.
using Motion = std::function<Eigen::Isometry3d(double)>;

// Returns a pose on a climbing circle of radius 1 m, one rotation in 2 pi seconds, looking along
// the tangent.
Eigen::Isometry3d helix(double t) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.rotate(Eigen::AngleAxisd(t, Eigen::Vector3d::UnitZ()));
    pose.translation() = Eigen::Vector3d(std::cos(t), std::sin(t), 0.1 * t);
    return pose;
}

Eigen::Isometry3d straight(double t) {
    return Eigen::Isometry3d(Eigen::Translation3d(t, 0.0, 0.0));
}

types::Trajectory sample(const Motion& motion, int num_poses, std::int64_t step_ns = kFrame_ns) {
    types::Trajectory trajectory;
    for (int i = 0; i < num_poses; ++i)
        trajectory.push_back({i * step_ns, motion(static_cast<double>(i * step_ns) * 1e-9)});
    return trajectory;
}

Eigen::Isometry3d some_transform() {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.rotate(Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -2, 0.5).normalized()));
    T.translation() = Eigen::Vector3d(5, -7, 11);
    return T;
}

types::Trajectory moved(const Eigen::Isometry3d& T, types::Trajectory trajectory) {
    for (types::StampedPose& pose : trajectory) pose.T_world_imu = T * pose.T_world_imu;
    return trajectory;
}

TEST(TrajectoryError, IsZeroForTheSamePathInAnotherWorld) {
    const types::Trajectory truth = sample(helix, 100);
    const TrajectoryError error = trajectory_error(moved(some_transform(), truth), truth);
    EXPECT_LT(error.ate_max_m, 1e-9);
    EXPECT_LT(error.rotation_rmse_deg, 1e-5);
    EXPECT_LT(error.end_drift_m, 1e-9);
    EXPECT_NEAR(error.sim3_scale, 1.0, 1e-9);
    EXPECT_TRUE(error.T_reference_estimate.isApprox(some_transform().inverse(), 1e-9));
}

TEST(TrajectoryError, AShiftOfOnePoseInFourIsTheShareItShouldBe) {
    // Alternating shifts of +-4 cm across the path change neither its centre nor the alignment.
    types::Trajectory truth = sample(straight, 400);
    types::Trajectory estimate = truth;
    for (std::size_t i = 0; i < estimate.size(); i += 4)
        estimate[i].T_world_imu.translation().z() += (i / 4) % 2 == 0 ? 0.04 : -0.04;
    const TrajectoryError error = trajectory_error(estimate, truth);
    EXPECT_NEAR(error.ate_rmse_m, 0.02, 1e-4);
    EXPECT_NEAR(error.ate_max_m, 0.04, 3e-4);
    EXPECT_NEAR(error.ate_median_m, 0.0, 3e-4);
}

TEST(TrajectoryError, ScaleIsReportedAndNotApplied) {
    const types::Trajectory truth = sample(helix, 63);
    types::Trajectory estimate = truth;
    for (types::StampedPose& pose : estimate) pose.T_world_imu.translation() *= 1.02;
    const TrajectoryError error = trajectory_error(estimate, truth);
    EXPECT_NEAR(error.sim3_scale, 1.0 / 1.02, 1e-9);
    EXPECT_LT(error.sim3_ate_rmse_m, 1e-9);
    EXPECT_GT(error.ate_rmse_m, 0.015);
    ASSERT_FALSE(error.segments.empty());
    EXPECT_NEAR(error.segments[0].translation_mean_percent, 2.0, 0.1);  // chords of arcs of 1 m
}

TEST(TrajectoryError, AConstantTurnRateErrorShowsAsDegreesPerMetre) {
    const types::Trajectory truth = sample(straight, 201);  // 20 m
    const Motion turning = [](double t) {
        constexpr double kRate = 0.01;  // rad/m
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.rotate(Eigen::AngleAxisd(kRate * t, Eigen::Vector3d::UnitZ()));
        pose.translation() =
            Eigen::Vector3d(std::sin(kRate * t), 1.0 - std::cos(kRate * t), 0.0) / kRate;
        return pose;
    };
    const TrajectoryError error = trajectory_error(sample(turning, 201), truth);
    ASSERT_EQ(error.segments.size(), 4U);
    for (const SegmentError& segment : error.segments) {
        EXPECT_NEAR(segment.rotation_mean_deg_per_m, 0.01 * 180.0 / M_PI, 1e-6);
        // The end of an arc of length L is about rate L / 2 of the length away from a straight
        // line.
        EXPECT_NEAR(segment.translation_mean_percent, 0.5 * segment.length_m, 0.02);
    }
    EXPECT_NEAR(error.path_length_m, 20.0, 1e-9);
    EXPECT_NEAR(error.end_drift_percent.value(), 10.0, 0.1);
}

TEST(TrajectoryError, WhatAShortPathDoesNotTellHasNoValue) {
    const auto of_length = [](double length_m) {
        return [length_m](double t) {
            Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
            pose.translation() = Eigen::Vector3d(length_m * std::min(t, 1.0), 0.0, 0.0);
            return pose;
        };
    };
    const types::Trajectory shorter = sample(of_length(0.9), 50);
    const nlohmann::json metrics = to_metrics(trajectory_error(shorter, shorter));
    EXPECT_TRUE(metrics.at("drift_percent").is_null()) << metrics.dump(2);
    EXPECT_EQ(metrics.at("end_drift_percent"), 0.0);

    const types::Trajectory still = sample(of_length(0.0), 50);
    EXPECT_TRUE(to_metrics(trajectory_error(still, still)).at("end_drift_percent").is_null());

    const types::Trajectory longer = sample(of_length(1.1), 50);
    EXPECT_EQ(to_metrics(trajectory_error(longer, longer)).at("drift_percent"), 0.0);
}

TEST(TrajectoryError, TruthIsInterpolatedToTheStampsOfTheEstimate) {
    const types::Trajectory truth = sample(straight, 50);
    types::Trajectory estimate = truth;
    for (types::StampedPose& pose : estimate) {
        pose.timestamp_ns += 30'000'000;
        pose.T_world_imu.translation().x() += 0.03;
    }
    const TrajectoryError error = trajectory_error(estimate, truth);
    EXPECT_EQ(error.num_poses, 49);
    EXPECT_EQ(error.num_poses_outside, 1);
    EXPECT_LT(error.ate_max_m, 1e-9);
}

TEST(TrajectoryError, ComingBackIsMeasuredAgainstTheFirstVisit) {
    const Motion circle = [](double t) {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() << 2.0 * std::cos(0.25 * t), 2.0 * std::sin(0.25 * t), 0.0;
        pose.rotate(Eigen::AngleAxisd(0.25 * t, Eigen::Vector3d::UnitZ()));
        return pose;
    };
    const types::Trajectory truth = sample(circle, 280);  // a lap takes 251.3
    types::Trajectory estimate = truth;
    for (std::size_t i = 250; i < estimate.size(); ++i)
        estimate[i].T_world_imu.translation().z() += 0.03;
    EXPECT_FALSE(trajectory_error(truth, sample(straight, 280)).revisit);
    const auto revisit = trajectory_error(estimate, truth).revisit;
    ASSERT_TRUE(revisit);
    EXPECT_GE(revisit->num_frames, 28);
    EXPECT_LE(revisit->num_frames, 60);
    EXPECT_NEAR(revisit->translation_max_m, 0.03, 1e-6);
    EXPECT_LT(revisit->rotation_rmse_deg, 1e-6);
}

TEST(TrajectoryError, ALongGapInTheTruthIsNotBridged) {
    types::Trajectory truth = sample(straight, 100);
    truth.erase(truth.begin() + 20, truth.begin() + 60);  // 4 s
    const TrajectoryError error = trajectory_error(sample(straight, 100), truth);
    EXPECT_EQ(error.num_poses, 60);
}

TEST(TrajectoryError, ALeverArmBetweenTheBodiesIsTakenOut) {
    const types::Trajectory truth = sample(helix, 100);
    TrajectoryErrorOptions options;
    options.T_referencebody_estimatebody.translation() = Eigen::Vector3d(0.1, 0.05, -0.2);
    types::Trajectory estimate = truth;
    for (types::StampedPose& pose : estimate)
        pose.T_world_imu = pose.T_world_imu * options.T_referencebody_estimatebody;
    EXPECT_LT(trajectory_error(estimate, truth, options).ate_max_m, 1e-9);
    EXPECT_GT(trajectory_error(estimate, truth).ate_max_m, 0.01);
}

TEST(TrajectoryError, AStraightPathIsStillAlignedAboutItself) {
    const types::Trajectory truth = sample(straight, 100);
    const TrajectoryError error = trajectory_error(moved(some_transform(), truth), truth);
    EXPECT_TRUE(error.T_reference_estimate.isApprox(some_transform().inverse(), 1e-9));
}

// The path weaves by 5 cm, from which positions give a poor roll: an error of 1 mm in phase with
// the weaving changes it by 1.15 degrees.
TEST(TrajectoryError, TheSurfaceOfANearlyStraightPathIsNotRolledByPositions) {
    const auto weave = [](double z_share, double t) -> Eigen::Isometry3d {
        return Eigen::Isometry3d(
            Eigen::Translation3d(t, 0.05 * std::sin(t), z_share * 0.05 * std::sin(t)));
    };
    const types::Trajectory truth = sample([&](double t) { return weave(0.0, t); }, 100);
    const types::Trajectory estimate = sample([&](double t) { return weave(0.02, t); }, 100);
    const TrajectoryError error = trajectory_error(estimate, truth);
    const auto angle = [](const Eigen::Isometry3d& T) {
        return Eigen::AngleAxisd(T.linear()).angle();
    };
    EXPECT_NEAR(angle(error.T_reference_estimate), 0.02, 2e-3);
    EXPECT_LT(angle(error.T_reference_surface), 1e-4);
}

TEST(TrajectoryError, TruthOfAnotherTimeIsAnErrorThatSaysSo) {
    types::Trajectory late = sample(straight, 100);
    for (types::StampedPose& pose : late) pose.timestamp_ns += 3'600'000'000'000;
    try {
        trajectory_error(sample(straight, 100), late);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::BadData);
        EXPECT_NE(std::string(error.what()).find("0 of 100 poses"), std::string::npos);
    }
}

TEST(TrajectoryError, GivesThePublishedMetricOfEvoOnKitti) {
    const auto folder = shared_data("evo");
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data: " << folder;
    const nlohmann::json metrics =
        evaluate_trajectory(folder / "KITTI_00_ORB.txt", folder / "KITTI_00_gt.txt");
    EXPECT_NEAR(metrics["ate_rmse_m"].get<double>(), 1.3034497145650266, 1e-6);
}

}  // namespace
}  // namespace divemesh::evaluation
