#include "worker/calibration/calibration_problem.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/synthetic/ideal_rig.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "tests/synthetic/tracked_dive.hpp"

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
        const auto late = [&](double t_s) {
            return Eigen::Isometry3d(rolling(10.0 * (t_s - kDelay_s)) *
                                     track_.rig.T_imu_cam.inverse());
        };
        recording_.its_rig = synthetic::ideal_cameras(track_.rig);
        recording_.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 2e-3, 2e-4};
        recording_.its_imu = synthetic::imu_along(late, 0.0, 0.5 * kNumKeyframes, {});
    }
    types::SolverOutcome solve(int max_rounds) {
        const imu::InertialPrior inertial(recording_, {}, {});
        CalibrationProblem problem(track_, recording_, inertial);
        const types::SolverOutcome outcome =
            problem.solve({}, base::ignore_progress, {}, max_rounds);
        time_offset_s_ = problem.unknowns().time_offset_s;
        return outcome;
    }

    const types::Track track_ = synthetic::tracked_dive(kNumKeyframes, rolling);
    synthetic::SensorRecording recording_;
    double time_offset_s_ = 0.0;
};

TEST_F(CalibrationProblemTest, ConvergesToTheDelayOfTheClock) {
    const types::SolverOutcome outcome = solve(CalibrationProblem::kMaxRounds);
    EXPECT_EQ(outcome.termination, Termination::Converged) << outcome.message;
    EXPECT_LT(outcome.final_cost, outcome.initial_cost);
    EXPECT_NEAR(time_offset_s_, kDelay_s, 0.002);
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
