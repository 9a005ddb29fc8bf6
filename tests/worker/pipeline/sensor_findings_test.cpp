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
    plan.time_offset_s = -0.25;
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
