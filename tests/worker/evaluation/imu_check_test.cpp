#include "worker/evaluation/imu_check.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace divemesh::evaluation {
namespace {

// Returns the pose of a rig that rolls about x by 0.5 sin(2 t) rad without moving.
Eigen::Isometry3d rolling(double t) {
    return Eigen::Isometry3d(Eigen::AngleAxisd(0.5 * std::sin(2.0 * t), Eigen::Vector3d::UnitX()));
}

types::Trajectory rolling_trajectory() {
    types::Trajectory trajectory;
    for (int i = 0; i < 100; ++i)
        trajectory.push_back({i * std::int64_t{100'000'000}, rolling(0.1 * i)});
    return trajectory;
}

std::vector<types::ImuSample> rolling_imu() {
    std::vector<types::ImuSample> imu;
    for (int i = -100; i < 2100; ++i) {
        const double t = 0.005 * i;
        const Eigen::Vector3d rate(std::cos(2.0 * t) + 0.03, 0.01, -0.02);  // with a bias
        imu.push_back({i * std::int64_t{5'000'000},
                       rate,
                       rolling(t).linear().transpose() * Eigen::Vector3d(0.0, 0.0, 9.81)});
    }
    return imu;
}

TEST(ImuCheck, GravityOfARollingRigPointsDownWithItsOwnSize) {
    const auto gravity = check_gravity(rolling_imu(), rolling_trajectory());
    ASSERT_TRUE(gravity.has_value());
    EXPECT_NEAR(gravity->magnitude_m_s2, 9.81, 0.01);
    EXPECT_LT(gravity->tilt_deg, 0.1);
}

TEST(ImuCheck, AnUpsideDownImuShowsAsTilt) {
    auto imu = rolling_imu();
    for (types::ImuSample& sample : imu) sample.acceleration_imu *= -1.0;
    EXPECT_NEAR(check_gravity(imu, rolling_trajectory())->tilt_deg, 180.0, 0.5);
}

TEST(ImuCheck, SaysNothingWithoutImu) {
    EXPECT_FALSE(check_gravity({}, rolling_trajectory()).has_value());
}

}  // namespace
}  // namespace divemesh::evaluation
