#include "worker/pipeline/sensor_findings.hpp"

#include <gtest/gtest.h>

namespace divemesh::pipeline {
namespace {

TEST(SensorFindingsTest, SensorsThatFitAreNotMentioned) {
    EXPECT_TRUE(sensor_findings({}).empty());
}

TEST(SensorFindingsTest, NamesTheMirroredAxis) {
    imu::SensorPlan plan;
    plan.left_out.imu = true;
    plan.gyroscope.fault = imu::GyroscopeFault::Mirrored;
    plan.gyroscope.axes = "z";
    const auto findings = sensor_findings(plan);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "imu_left_out");
    EXPECT_NE(findings[0].message.find("axis z of the IMU is mirrored"), std::string::npos);
}

TEST(SensorFindingsTest, SaysOnWhichSideTheClockIs) {
    imu::SensorPlan plan;
    plan.alignment.time_offset_s = -0.25;
    const auto findings = sensor_findings(plan);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "imu_clock_offset");
    EXPECT_NE(findings[0].message.find("250 ms behind"), std::string::npos);
}

TEST(SensorFindingsTest, AnImuThatWasNeverConfirmedIsSaidToBeLeftOut) {
    imu::SensorPlan plan;
    plan.left_out.imu = plan.imu_unconfirmed = true;
    ASSERT_EQ(sensor_findings(plan).size(), 1U);
    EXPECT_EQ(sensor_findings(plan)[0].code, "imu_left_out");
}

TEST(SensorFindingsTest, AnImuLeftOutForATimeIsExplainedWithoutAJudgement) {
    imu::SensorPlan plan;
    plan.left_out.imu_times = {{0, 4'000'000'000}};
    const auto findings = sensor_findings(plan);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "imu_left_out_for_a_time");
    EXPECT_NE(findings[0].message.find("for 4 s"), std::string::npos);
    EXPECT_EQ(findings[0].message.find("mismatch"), std::string::npos);
}

TEST(SensorFindingsTest, AnAccelerometerThatCouldNotBeTestedIsNotAccused) {
    imu::SensorPlan plan;
    plan.left_out.accelerometer = true;
    ASSERT_EQ(sensor_findings(plan).size(), 1U);
    EXPECT_NE(sensor_findings(plan)[0].message.find("could test"), std::string::npos);
    plan.gravity_disagreement_m_s2 = 1.4;
    EXPECT_NE(sensor_findings(plan)[0].message.find("1.4 m/s^2"), std::string::npos);
    plan.accelerometer_clipped = true;  // the dive's findings say so
    EXPECT_TRUE(sensor_findings(plan).empty());
}

TEST(SensorFindingsTest, ABiasThatNoGyroscopeHasIsNamed) {
    imu::SensorPlan plan;
    plan.left_out.imu = true;
    plan.gyroscope.fault = imu::GyroscopeFault::Biased;
    plan.gyroscope.bias_rad_s = 4.5;
    EXPECT_NE(sensor_findings(plan)[0].message.find("off by 4.5 rad/s"), std::string::npos);
}

TEST(SensorFindingsTest, NoiseBeyondTheDataSheetsIsSaid) {
    const types::ImuNoise stated{.gyroscope_noise_density = 2e-4,
                                 .accelerometer_noise_density = 2e-3};
    std::vector<types::ImuSample> samples(1000);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        samples[i].timestamp_ns = static_cast<std::int64_t>(i) * 5'000'000;
        samples[i].acceleration_imu = {0.0, 0.0, 9.81};
        // Alternating values have second differences of four times their size, as white noise has
        // whose sigma is 4 / sqrt(6) of it.
        samples[i].angular_velocity_imu.setConstant(i % 2 == 0 ? 0.01 : -0.01);
    }
    const auto noisy = imu_noisy(samples, stated, true);
    ASSERT_TRUE(noisy);
    EXPECT_EQ(noisy->severity, Severity::Info);
    // 0.01 * 4 / sqrt(6) * sqrt(0.005 s) = 1.15e-3, 5.8 times 2e-4.
    EXPECT_NE(noisy->message.find("gyroscope 6 times"), std::string::npos) << noisy->message;
    EXPECT_EQ(noisy->message.find("accelerometer"), std::string::npos) << noisy->message;
    for (types::ImuSample& sample : samples) sample.angular_velocity_imu *= 0.1;
    EXPECT_FALSE(imu_noisy(samples, stated, true));
}

TEST(SensorFindingsTest, AnAhrsIsLeftOutForATime) {
    imu::SensorPlan plan;
    plan.left_out.ahrs_times = {{0, 4'000'000'000}, {9'000'000'000, 12'000'000'000}};
    const auto findings = sensor_findings(plan);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "ahrs_left_out_for_a_time");
    EXPECT_NE(findings[0].message.find("for 7 s"), std::string::npos);
}

TEST(SensorFindingsTest, NamesWhatIsWrongWithTheAhrs) {
    imu::SensorPlan plan;
    plan.left_out.ahrs = true;
    plan.ahrs.fault = imu::AhrsFault::ScalarLast;
    const auto findings = sensor_findings(plan);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "ahrs_left_out");
    EXPECT_NE(findings[0].message.find("w is the last number"), std::string::npos);
    // An IMU that is left out too is said as well.
    plan.left_out.imu = true;
    EXPECT_EQ(sensor_findings(plan).size(), 2U);
}

TEST(SensorFindingsTest, NamesWhatIsWrongWithThePressureSensor) {
    imu::PressureJudgement judgement;
    judgement.fault = imu::PressureFault::Reversed;
    judgement.scale = -1.0;
    const Finding finding = pressure_left_out(judgement);
    EXPECT_EQ(finding.code, "pressure_left_out");
    EXPECT_NE(finding.message.find("counts upwards"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::pipeline
