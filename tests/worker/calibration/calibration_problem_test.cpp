#include "worker/calibration/calibration_problem.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/synthetic/ideal_rig.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "tests/synthetic/tracked_dive.hpp"
#include "worker/calibration/calibration_refinement.hpp"

namespace divemesh::calibration {
namespace {

using Termination = types::SolverOutcome::Termination;

constexpr int kNumKeyframes = 16;
constexpr double kDelay_s = 0.02;

// The path of stereo_world.hpp on a rig that rolls in the waves, so that its gyroscope tells time.
Eigen::Isometry3d rolling(double frame) {
    Eigen::Isometry3d T_world_cam = synthetic::T_world_cam(frame);
    T_world_cam.rotate(Eigen::AngleAxisd(0.1 * std::sin(0.3 * frame), Eigen::Vector3d::UnitZ()));
    return T_world_cam;
}

// A dive whose IMU has another clock than its cameras.
class CalibrationProblemTest : public testing::Test {
protected:
    CalibrationProblemTest() {
        recording_.its_rig = synthetic::ideal_cameras(track_.rig);
        recording_.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 2e-3, 2e-4};
        delay_imu(kDelay_s);
    }
    void delay_imu(double delay_s) {
        const auto late = [&](double t_s) {
            return Eigen::Isometry3d(rolling(10.0 * (t_s - delay_s)) *
                                     track_.rig.T_imu_cam.inverse());
        };
        recording_.its_imu = synthetic::imu_along(late, 0.0, 0.5 * kNumKeyframes + 1.0, {});
    }
    CalibrationRefinement refined(const ReconstructionOptions& options) const {
        return refine_calibration(track_,
                                  recording_,
                                  options,
                                  {},
                                  imu::InertialPrior(recording_, {}, {}),
                                  base::ignore_progress,
                                  {});
    }
    types::SolverOutcome solve(int max_rounds) {
        const imu::InertialPrior inertial(recording_, {}, {});
        CalibrationProblem problem(track_, recording_, {}, inertial);
        const types::SolverOutcome outcome =
            problem.solve({}, base::ignore_progress, {}, max_rounds);
        time_offset_s_ = problem.unknowns().time_offset_s;
        return outcome;
    }

    types::Track track_ = synthetic::tracked_dive(kNumKeyframes, rolling);
    synthetic::SensorRecording recording_;
    double time_offset_s_ = 0.0;
};

TEST_F(CalibrationProblemTest, ConvergesToTheDelayOfTheClock) {
    const types::SolverOutcome outcome = solve(CalibrationProblem::kMaxRounds);
    EXPECT_EQ(outcome.termination, Termination::Converged) << outcome.message;
    EXPECT_LT(outcome.final_cost, outcome.initial_cost);
    EXPECT_NEAR(time_offset_s_, kDelay_s, 0.002);
}

TEST_F(CalibrationProblemTest, FindsRatesThatAreTooLarge) {
    delay_imu(0.0);
    const Eigen::Vector3d error(0.0, 0.0, 0.03);  // the path rolls most about this axis
    for (types::ImuSample& sample : recording_.its_imu)
        sample.angular_velocity_imu += error.cwiseProduct(sample.angular_velocity_imu);
    const types::RefinedCalibration found =
        refined(make_options("standard", nlohmann::json::object())).calibration;
    EXPECT_TRUE(found.rate_error_applied);
    EXPECT_NEAR(found.applied_alignment().rate_error.z(), 0.03 / 1.03, 0.005);
}

TEST_F(CalibrationProblemTest, RightRatesAreLeftAsTheyAre) {
    EXPECT_FALSE(
        refined(make_options("standard", nlohmann::json::object())).calibration.rate_error_applied);
}

// The dive was tracked with an offset of half a second, so the estimate lies near it.
TEST_F(CalibrationProblemTest, ConvergesToADelayThatTrackingFound) {
    delay_imu(0.5);
    track_.imu_alignment.time_offset_s = 0.49;
    solve(CalibrationProblem::kMaxRounds);
    EXPECT_NEAR(time_offset_s_, 0.5, 0.002);
}

TEST_F(CalibrationProblemTest, WhatTrackingFoundIsUsedWhereNothingBetterIsKnown) {
    track_.imu_alignment.time_offset_s = 0.3;
    ReconstructionOptions options = make_options("standard", nlohmann::json::object());
    options.align_imu = false;
    EXPECT_EQ(refined(options).calibration.applied_alignment().time_offset_s, 0.3);
    track_.keyframes.resize(3);
    for (types::Landmark& landmark : track_.landmarks)
        std::erase_if(landmark.observations, [](const auto& seen) { return seen.keyframe > 2; });
    types::RefinedCalibration few =
        refined(make_options("standard", nlohmann::json::object())).calibration;
    EXPECT_EQ(few.applied_alignment().time_offset_s, 0.3);
    few.leave_as_stated();
    EXPECT_EQ(few.applied_alignment().time_offset_s, 0.3);
}

TEST_F(CalibrationProblemTest, AnEstimateThatThereIsNoDelayReplacesWhatTrackingFound) {
    delay_imu(0.0);
    track_.imu_alignment.time_offset_s = 0.008;
    const types::RefinedCalibration found =
        refined(make_options("standard", nlohmann::json::object())).calibration;
    EXPECT_NEAR(found.applied_alignment().time_offset_s, 0.0, 0.002);
}

// A round starts from the linearisation of the one before, so the first is never the last.
TEST_F(CalibrationProblemTest, SaysByHowMuchItStillMovedWhereRoundsDoNotSuffice) {
    const types::SolverOutcome outcome = solve(1);
    EXPECT_EQ(outcome.termination, Termination::StoppedAtLimit);
    EXPECT_GT(outcome.last_step_sigmas, 1.0);
    EXPECT_TRUE(outcome.still_moving());
}

}  // namespace
}  // namespace divemesh::calibration
