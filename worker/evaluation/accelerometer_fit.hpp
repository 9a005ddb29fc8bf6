#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "worker/evaluation/scale_check.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// What an accelerometer tells about a path.
struct AccelerometerFit {
    ScaleCheck scale;
    // The position of the accelerometer relative to the origin of the path's body frame, axes of
    // imu.
    Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();
    Eigen::Matrix3d lever_arm_covariance_m2 = Eigen::Matrix3d::Zero();
    std::ptrdiff_t num_windows = 0;  // a second each, or half of what twelve frames take
};

// Compares the accelerometer with the path. Both are weighted by windows w(t) = sin^4(pi t / T)
// that overlap by half, so that no velocity is needed (modulating functions, Shinbrot 1957):
//
//     integral w (R_world_imu (a - b + e x a) + g) dt
//         = s integral w'' (p_world_imu + R_world_imu l) dt
//
// The path errs by more than the accelerometer, so the least squares explain the left side of
//
//     integral w'' p dt = integral w (R (a - b + e x a) + g) / s - w'' R l dt
//
// where R of l follows the gyroscope alone, and the noise of the accelerations is taken off their
// squares (errors in variables, Fuller 1987). Unknowns are the deviation of gravity g from 9.81
// m/s^2 along -z and the bias b, each constant for a minute, the scale s, the lever arm l and the
// rotation e of the accelerometer's axes to the gyroscope's, constant for the whole dive. Their
// priors are zero, to 0.5 m/s^2, 5 cm and 5 mrad in each axis: without rotation of the rig the
// sigmas stay there. Sigmas are those of the residuals, wider for few of them; that of the scale is
// of the windows that tell it, as a rig at rest has hardly any residuals. A window is two
// seconds, or as long as twelve frames take; between frames the rotation follows the gyroscope.
// Returns nullopt without accelerometer data, if frames are more than 0.6 s apart, or if fewer than
// five windows are covered without a gap.
std::optional<AccelerometerFit> fit_accelerometer(const std::vector<types::ImuSample>& imu,
                                                  const types::Trajectory& trajectory);

// Returns the scale of fit_accelerometer().
std::optional<ScaleCheck> scale_by_accelerometer(const std::vector<types::ImuSample>& imu,
                                                 const types::Trajectory& trajectory);

// Returns why fit_accelerometer() returns nullopt.
std::string why_no_scale_by_accelerometer(const std::vector<types::ImuSample>& imu,
                                          const types::Trajectory& trajectory);

}  // namespace divemesh::evaluation
