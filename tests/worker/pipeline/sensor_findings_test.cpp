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
    plan.left_out.imu = plan.imu_on_probation = true;
    ASSERT_EQ(sensor_findings(plan).size(), 1U);
    EXPECT_EQ(sensor_findings(plan)[0].code, "imu_left_out");
}

}  // namespace
}  // namespace divemesh::pipeline
