#pragma once

#include <Eigen/Geometry>

namespace divemesh::types {

// The error of the calibration between the IMU and the cameras, in time and rotation, and of the
// gyroscope's scale. Frame `body`
// is the IMU as calibrated, fixed to the cameras; `imu` is how the IMU is really mounted. Both
// share one origin.
struct ImuAlignment {
    double time_offset_s = 0.0;  // t_imu = t_cam + offset, as in Kalibr
    Eigen::Quaterniond q_body_imu = Eigen::Quaterniond::Identity();
    // The share of a reading by which it is too large, axes of imu; of rates without their bias.
    Eigen::Vector3d rate_error = Eigen::Vector3d::Zero();
};

}  // namespace divemesh::types
