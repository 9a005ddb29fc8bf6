#include "worker/imu/judge_pressure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace divemesh::imu {
namespace {

constexpr double kDuration_s = 40.0;

double depth_at(double t_s) { return 8.0 + 0.4 * std::sin(0.5 * t_s) + 0.2 * std::sin(0.21 * t_s); }

// Returns a path at ten poses a second, in a world that is turned by `tilt_rad`.
types::Trajectory path(double tilt_rad, double range_m = 1.0) {
    const Eigen::AngleAxisd tilt(tilt_rad, Eigen::Vector3d::UnitY());
    types::Trajectory trajectory;
    for (int k = 0; k < std::lround(10.0 * kDuration_s); ++k) {
        const double t_s = 0.1 * k;
        types::StampedPose pose{100'000'000LL * k};
        pose.T_world_imu.translation() =
            tilt * Eigen::Vector3d(0.3 * t_s, std::sin(0.3 * t_s), -range_m * depth_at(t_s));
        trajectory.push_back(pose);
    }
    return trajectory;
}

// Judges a sensor that reads `reading(t_s)` at 5 Hz.
template <typename Reading>
PressureJudgement judged(const Reading& reading,
                         const types::Trajectory& trajectory = path(0.0),
                         bool vertical_is_known = true) {
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0.0, 0.003);
    std::vector<types::PressureSample> pressure;
    for (int k = 0; k < std::lround(5.0 * kDuration_s); ++k)
        pressure.push_back({200'000'000LL * k, reading(0.2 * k) + noise(random)});
    return judge_pressure(pressure, trajectory, {}, vertical_is_known);
}

TEST(JudgePressureTest, AGoodOneFits) {
    EXPECT_EQ(judged(depth_at).fault, PressureFault::None);
    EXPECT_EQ(judged(depth_at, path(0.05)).fault, PressureFault::None);
    EXPECT_EQ(judged(depth_at, path(0.3), false).fault, PressureFault::None);
}

TEST(JudgePressureTest, WavesASpikeAndTheCamerasScaleAreNoContradiction) {
    const auto with_waves = [](double t_s) { return depth_at(t_s) + 0.05 * std::sin(1.3 * t_s); };
    EXPECT_EQ(judged(with_waves).fault, PressureFault::None);
    const auto with_spike = [](double t_s) {
        return std::abs(t_s - 20.0) < 0.01 ? 100.0 : depth_at(t_s);
    };
    EXPECT_EQ(judged(with_spike).fault, PressureFault::None);
    EXPECT_EQ(judged(depth_at, path(0.0, 1.1)).fault, PressureFault::None);
}

TEST(JudgePressureTest, NamesTheSign) {
    EXPECT_EQ(judged([](double t_s) { return -depth_at(t_s); }).fault, PressureFault::Reversed);
}

TEST(JudgePressureTest, NamesTheScale) {
    for (const double scale : {0.5, 10.0}) {
        const auto found = judged([&](double t_s) { return scale * depth_at(t_s); });
        EXPECT_EQ(found.fault, PressureFault::Scaled);
        EXPECT_NEAR(found.scale, scale, 0.05 * scale);
    }
}

TEST(JudgePressureTest, NamesReadingsThatStay) {
    const auto found = judged([](double t_s) { return std::max(8.1, depth_at(t_s)); });
    EXPECT_EQ(found.fault, PressureFault::Held);
    EXPECT_GT(found.held_share, 0.4);
}

// 98 is metres in mbar, whose noise grows with them.
TEST(JudgePressureTest, NamesTheScaleOfOtherUnitsWithTheWavesInThem) {
    const auto found =
        judged([](double t_s) { return 98.0 * (depth_at(t_s) + 0.02 * std::sin(1.3 * t_s)); });
    EXPECT_EQ(found.fault, PressureFault::Scaled);
    EXPECT_NEAR(found.scale, 98.0, 3.0);
}

TEST(JudgePressureTest, NamesAZeroThatMoved) {
    for (const double step_m : {0.3, -1.0}) {
        const auto found =
            judged([&](double t_s) { return depth_at(t_s) + (t_s > 23.0 ? step_m : 0.0); });
        EXPECT_EQ(found.fault, PressureFault::Stepped) << step_m;
        EXPECT_NEAR(found.step_m, step_m, 0.1);
    }
}

TEST(JudgePressureTest, SwellIsNoStep) {
    const auto with_swell = [](double t_s) { return depth_at(t_s) + 0.12 * std::sin(0.9 * t_s); };
    EXPECT_EQ(judged(with_swell).fault, PressureFault::None);
    const auto with_a_wake = [](double t_s) {
        return depth_at(t_s) + (std::abs(t_s - 20.0) < 5.0 ? 0.2 * std::sin(1.4 * t_s) : 0.0);
    };
    EXPECT_EQ(judged(with_a_wake).fault, PressureFault::None);
}

// A slow sensor reads between two poses, and one that lags reads less while the rig sinks.
TEST(JudgePressureTest, ADescentIsNoStep) {
    types::Trajectory descent = path(0.0);
    const auto sunk_m = [](double t_s) { return std::clamp(1.0 * (t_s - 15.0), 0.0, 10.0); };
    for (types::StampedPose& pose : descent)
        pose.T_world_imu.translation().z() -= sunk_m(1e-9 * static_cast<double>(pose.timestamp_ns));
    for (const double lag_s : {0.0, 0.3})
        for (const int period_ms : {200, 500, 1000}) {
            std::vector<types::PressureSample> pressure;
            for (int t_ms = 130; t_ms < 1000 * kDuration_s; t_ms += period_ms) {
                const double t_s = 1e-3 * t_ms - lag_s;
                pressure.push_back({t_ms * std::int64_t{1'000'000}, depth_at(t_s) + sunk_m(t_s)});
            }
            EXPECT_EQ(judge_pressure(pressure, descent, {}, true).fault, PressureFault::None)
                << lag_s << " s " << period_ms << " ms";
        }
}

// A path that keeps its depth does not tell the scale, and a wrong one explains nothing.
TEST(JudgePressureTest, AnotherDiveIsUnexplainedWhereThePathIsLevel) {
    types::Trajectory level = path(0.0);
    for (std::size_t i = 0; i < level.size(); ++i)
        level[i].T_world_imu.translation().z() =
            -8.0 + 0.02 * std::sin(0.11 * static_cast<double>(i));
    EXPECT_EQ(judged([](double t_s) { return 8.0 + 1.0 * std::sin(t_s / 2.3); }, level).fault,
              PressureFault::Unexplained);
}

TEST(JudgePressureTest, AnotherDiveIsUnexplained) {
    EXPECT_EQ(judged([](double t_s) { return 8.0 + 1.5 * std::sin(t_s / 1.7); }).fault,
              PressureFault::Unexplained);
}

TEST(JudgePressureTest, ADiveThatKeepsItsDepthTellsNothing) {
    const auto level = [] {
        types::Trajectory trajectory = path(0.0);
        for (types::StampedPose& pose : trajectory) pose.T_world_imu.translation().z() = -8.0;
        return trajectory;
    };
    EXPECT_EQ(judged([](double) { return 8.0; }, level()).fault, PressureFault::None);
}

}  // namespace
}  // namespace divemesh::imu
