#include "worker/pipeline/check_cameras.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/sensor_recording.hpp"
#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"

namespace divemesh::pipeline {
namespace {

// Returns a pair with fields of view of 40 degrees; the right camera is turned towards the left
// one.
synthetic::SensorRecording turned_inward(double angle_deg) {
    synthetic::SensorRecording recording;
    types::Rig& rig = recording.its_rig;
    rig.cam0 = {640, 480, 880.0, 880.0, 319.5, 239.5, types::Distortion::None, {}};
    rig.cam1 = rig.cam0;
    rig.T_imu_cam1 = rig.T_imu_cam0 * Eigen::Translation3d(0.12, 0.0, 0.0);
    rig.T_imu_cam1.rotate(base::rotation_from_vector({0.0, -base::kRadPerDeg * angle_deg, 0.0}));
    return recording;
}

TEST(CheckCamerasTest, CamerasThatSeeHardlyAnythingInCommonAreAnError) {
    for (const double angle_deg : {36.0, 40.0, 44.0}) {
        const auto findings = check_cameras(turned_inward(angle_deg), base::ignore_progress);
        ASSERT_EQ(findings.size(), 1U) << angle_deg;
        EXPECT_EQ(findings[0].code, "calibration_no_overlap");
        EXPECT_EQ(findings[0].severity, Severity::Error);
        EXPECT_NE(findings[0].message.find(std::to_string(static_cast<int>(angle_deg)) + ".0 deg"),
                  std::string::npos)
            << findings[0].message;
        EXPECT_FALSE(findings[0].remedy.empty());
    }
}

TEST(CheckCamerasTest, CamerasThatSeeTheSameSceneMayConverge) {
    for (const double angle_deg : {0.0, 10.0, 20.0})
        EXPECT_FALSE(find_no_overlap(turned_inward(angle_deg))) << angle_deg;
}

}  // namespace
}  // namespace divemesh::pipeline
