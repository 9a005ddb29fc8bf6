#pragma once

#include <optional>
#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// The mean of the accelerometer over a dive, rotated into the world by the trajectory. For a
// correct calibration it is the reaction to gravity, 9.81 m/s^2 straight up; it reveals a wrong
// unit, a wrong axis or an inverted camera-IMU transform.
struct GravityCheck {
    double magnitude_m_s2 = 0.0;
    double tilt_deg = 0.0;  // between the mean and the world's z
};

// Returns nullopt if there is no IMU or it does not overlap the trajectory in time.
std::optional<GravityCheck> check_gravity(const std::vector<types::ImuSample>& imu,
                                          const types::Trajectory& trajectory);

}  // namespace divemesh::evaluation
