#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/types/recording.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::imu {

// The rotation of the body between two times from the gyroscope, with its derivative with respect
// to the bias, so that a changed bias needs no new integration (Forster et al., "On-manifold
// preintegration", 2017, for the rotation).
struct GyroscopeIntegral {
    double duration_s = 0.0;
    Eigen::Quaterniond q_from_to = Eigen::Quaterniond::Identity();  // imu at `to` in imu at `from`
    Eigen::Vector3d bias = Eigen::Vector3d::Zero();                 // rad/s, already subtracted
    Eigen::Matrix3d d_rotation_d_bias = Eigen::Matrix3d::Zero();
    double sigma_rad = 0.0;  // per axis, by the noise density

    // Returns q_from_to for another bias (rad/s), to first order.
    Eigen::Quaterniond rotation(const Eigen::Vector3d& other_bias) const;
};

// Returns the integral by the trapezoidal rule over the samples' own intervals, with interpolated
// ends. nullopt if the samples do not cover the interval or leave a gap of more than 0.1 s in it.
std::optional<GyroscopeIntegral> integrate_gyroscope(const std::vector<types::ImuSample>& samples,
                                                     std::int64_t from_ns,
                                                     std::int64_t to_ns,
                                                     const Eigen::Vector3d& bias,
                                                     const types::ImuNoise& noise);

}  // namespace divemesh::imu
