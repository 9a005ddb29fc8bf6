#pragma once

#include <Eigen/Core>
#include <optional>

#include "schemas/finding.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/refined_calibration.hpp"
#include "worker/types/sensors_left_out.hpp"

namespace divemesh::pipeline {

// Where the accelerometer of an adjusted track is.
struct LeverArm {
    Eigen::Vector3d from_stated_m = Eigen::Vector3d::Zero();  // axes of imu
    Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
    bool is_significant = false;  // and longer than a centimetre
    bool is_still = false;        // the adjusted track has it where it was found, within its sigma
};

// Returns the lever arm that the accelerometer tells (evaluation::fit_accelerometer), nullopt where
// nothing tells it: without an accelerometer, or in a dive of several segments.
std::optional<LeverArm> find_lever_arm(const types::OptimisedTrack& adjusted,
                                       const types::Recording& recording,
                                       const types::SensorsLeftOut& left_out);

// Returns a warning if the IMU is elsewhere in the rig than the calibration says.
std::optional<Finding> lever_arm_finding(const types::RefinedCalibration& calibration);

}  // namespace divemesh::pipeline
