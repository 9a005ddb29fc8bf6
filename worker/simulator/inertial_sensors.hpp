#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/simulator/diver_motion.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::simulator {

constexpr double kGravity = 9.81;  // m/s^2, along -z of the world
constexpr double kImuRateHz = 200.0;
constexpr double kAhrsRateHz = 100.0;
constexpr double kPressureRateHz = 10.0;
constexpr double kSensorMargin_s = 0.5;  // sensors record before the first and after the last frame
constexpr std::int64_t kFirstFrame_ns = 1'700'000'000'000'000'000;

// An IMU sample of the body and the ground truth of the same moment.
struct ImuRecord {
    types::ImuSample sample;
    MotionState truth;
    Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();      // rad/s
    Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  // m/s^2
};

// Returns records from -kSensorMargin_s to `duration_s` + kSensorMargin_s; exact values if `noise`
// is null.
std::vector<ImuRecord> simulate_imu(const DiverMotion& motion,
                                    double duration_s,
                                    const types::ImuNoise* noise,
                                    std::uint64_t seed);
// Returns orientations with an error of 0.3 to 0.5 degrees that varies slowly (12 s in tilt, 25 s
// in heading) and 0.02 degrees of white noise.
std::vector<types::OrientationSample> simulate_ahrs(const DiverMotion& motion,
                                                    double duration_s,
                                                    bool noise,
                                                    std::uint64_t seed);
// Returns the depth below a water surface at height `surface_z_m` of the world, with 5 mm of noise.
std::vector<types::PressureSample> simulate_pressure(const DiverMotion& motion,
                                                     double duration_s,
                                                     double surface_z_m,
                                                     bool noise,
                                                     std::uint64_t seed);

}  // namespace divemesh::simulator
