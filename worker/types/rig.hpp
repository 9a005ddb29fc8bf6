#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/types/camera.hpp"

namespace divemesh::types {

// The noise densities and random walks of the IMU.
struct ImuNoise {
    double gyroscope_noise_density = 2e-3;      // rad/s/sqrt(Hz)
    double gyroscope_random_walk = 2e-5;        // rad/s^2/sqrt(Hz)
    double accelerometer_noise_density = 2e-2;  // m/s^2/sqrt(Hz)
    double accelerometer_random_walk = 3e-3;    // m/s^3/sqrt(Hz)
};

// The right camera from a time on, until that of the next one: something moved it in mid-dive.
struct CameraTurn {
    std::int64_t from_ns = 0;
    Eigen::Vector3d rotation = Eigen::Vector3d::Zero();  // rotation vector about its own axes, rad
    double focal = 0.0;                                  // change of its focal length, relative
};

// The calibrated cameras and IMU: the one internal calibration type. Frame `imu` is the body;
// without an IMU the body is cam0 and T_imu_cam0 is the identity.
struct Rig {
    Camera cam0;
    Camera cam1;
    Eigen::Isometry3d T_imu_cam0 = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d T_imu_cam1 = Eigen::Isometry3d::Identity();
    std::optional<ImuNoise> imu_noise;  // nullopt if the dive has no IMU
    // The standard deviation of the part of StereoFrame::right_delay_s that all frames share, times
    // the median speed of the rig, relative to the baseline: a delay that is not known acts like
    // another baseline where the rig moves along it.
    double right_delay_baseline_sigma = 0.0;
    std::vector<CameraTurn> right_turns;  // against T_imu_cam1; ascending, most dives have none

    Eigen::Isometry3d T_cam1_cam0() const { return T_imu_cam1.inverse() * T_imu_cam0; }
    double baseline_m() const { return T_cam1_cam0().translation().norm(); }
};

}  // namespace divemesh::types
