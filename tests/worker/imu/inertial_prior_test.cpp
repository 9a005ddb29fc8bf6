#include "worker/imu/inertial_prior.hpp"

#include <gtest/gtest.h>

#include "schemas/reconstruction_options.hpp"
#include "tests/synthetic/sensor_recording.hpp"

namespace divemesh::imu {
namespace {

constexpr double kRate_rad_s = 0.4;  // of the body, about z

Eigen::Quaterniond heading(double angle_rad) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()));
}

// Returns the recording of a body that rotates about the vertical; `gyroscope_rad_s` is what its
// gyroscope measures.
synthetic::SensorRecording turning_body(double gyroscope_rad_s) {
    synthetic::SensorRecording recording;
    recording.its_rig.imu_noise = types::ImuNoise{};
    for (int i = 0; i <= 200; ++i) {
        const std::int64_t time_ns = std::int64_t{i} * 5'000'000;
        const double angle = kRate_rad_s * 1e-9 * static_cast<double>(time_ns);
        recording.its_imu.push_back({time_ns, {0.0, 0.0, gyroscope_rad_s}, {0.0, 0.0, 9.81}});
        recording.its_ahrs.push_back({time_ns, heading(angle)});
    }
    return recording;
}

constexpr std::int64_t kFrom_ns = 400'000'000;
constexpr std::int64_t kTo_ns = 500'000'000;
constexpr double kDrift_rad = 0.05;  // of the estimate relative to the AHRS

TEST(InertialPrior, AnAhrsThatLeadsPullsADriftBack) {
    const auto recording = turning_body(kRate_rad_s);
    InertialPrior inertial(recording, preset_options("paper"));
    inertial.let_ahrs_lead();
    const auto drifted = heading(kRate_rad_s * 0.4 + kDrift_rad);
    const auto rotation = inertial.rotation_from(drifted, kFrom_ns, kTo_ns);
    ASSERT_TRUE(rotation);
    EXPECT_NEAR((drifted * rotation->q).angularDistance(heading(kRate_rad_s * 0.5)), 0.0, 1e-6);
}

TEST(InertialPrior, WithoutAnAhrsTheGyroscopeGivesTheChangeOfOrientation) {
    auto recording = turning_body(kRate_rad_s);
    recording.its_ahrs.clear();
    InertialPrior inertial(recording, preset_options("paper"));
    inertial.let_ahrs_lead();
    const auto rotation = inertial.rotation_from(heading(kDrift_rad), kFrom_ns, kTo_ns);
    ASSERT_TRUE(rotation);
    EXPECT_NEAR(rotation->q.angularDistance(heading(kRate_rad_s * 0.1)), 0.0, 1e-6);
}

TEST(InertialPrior, TheWindowTakesTheChangeFromTheGyroscopeThoughThereIsAnAhrs) {
    const auto recording = turning_body(0.7);
    const InertialPrior inertial(recording, preset_options("standard"));
    const auto rotation = inertial.rotation_from(heading(kDrift_rad), kFrom_ns, kTo_ns);
    ASSERT_TRUE(rotation);
    EXPECT_NEAR(rotation->q.angularDistance(heading(0.07)), 0.0, 1e-6);
}

TEST(InertialPrior, TheVerticalIsKnownOnlyWhereSamplesOfTheNextSecondMeasureIt) {
    auto recording = turning_body(kRate_rad_s);  // its samples are of one second
    recording.its_ahrs.clear();
    const InertialPrior inertial(recording, preset_options("standard"));
    EXPECT_TRUE(inertial.knows_vertical(0));
    EXPECT_TRUE(inertial.knows_vertical(-500'000'000));
    EXPECT_FALSE(inertial.knows_vertical(-1'500'000'000));
    EXPECT_FALSE(inertial.knows_vertical(1'500'000'000));
}

TEST(InertialPrior, WithoutSamplesOfTheNextSecondTheCameraIsAssumedToBeLevel) {
    auto recording = turning_body(kRate_rad_s);
    recording.its_ahrs.clear();
    const InertialPrior inertial(recording, preset_options("standard"));
    const Eigen::Matrix3d R_imu_cam =
        Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()).toRotationMatrix();
    const auto up_world = [&](std::int64_t time_ns, const Eigen::Vector3d& up_imu) {
        return Eigen::Vector3d(inertial.initial_orientation(time_ns, R_imu_cam) * up_imu);
    };
    EXPECT_NEAR(up_world(0, Eigen::Vector3d::UnitZ()).z(), 1.0, 1e-6);
    EXPECT_NEAR(up_world(1'500'000'000, -R_imu_cam.col(1)).z(), 1.0, 1e-6);
}

}  // namespace
}  // namespace divemesh::imu
