#pragma once

#include <optional>
#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// What the accelerometer says about the rig as calibrated: turned into the world by the
// trajectory, its mean over a dive is gravity's reaction, 9.81 m/s^2 straight up. A wrong unit, a
// wrong axis or an inverted camera-IMU transform shows here.
struct GravityCheck {
    double magnitude_m_s2 = 0.0;
    double tilt_deg = 0.0;  // between the mean and the world's z
};

// Nothing when there is no IMU or it does not overlap the trajectory in time.
std::optional<GravityCheck> check_gravity(const std::vector<types::ImuSample>& imu,
                                          const types::Trajectory& trajectory);

}  // namespace divemesh::evaluation
