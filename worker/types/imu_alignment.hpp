#pragma once

#include <Eigen/Geometry>

namespace divemesh::types {

// How the inertial unit stands beside the cameras' clock and frame: what the calibration misses.
// Frame `body` is the imu as calibrated, fixed to the cameras; `imu` is how the unit really sits.
// Both have one origin.
struct ImuAlignment {
    double time_offset_s = 0.0;  // t_imu = t_cam + offset, as Kalibr has it
    Eigen::Quaterniond q_body_imu = Eigen::Quaterniond::Identity();
};

}  // namespace divemesh::types
