#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/imu/estimate_alignment.hpp"
#include "worker/imu/gyroscope_integral.hpp"
#include "worker/imu/preintegration.hpp"
#include "worker/types/known_rotation.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::imu {

constexpr double kInitialGyroscopeBiasSigma = 0.02;     // rad/s, of a cheap sensor
constexpr double kInitialAccelerometerBiasSigma = 0.1;  // m/s^2

// What the sensors say about one time, and about the motion to it from an earlier one.
struct SensorReadings {
    double interval_s = 0.0;
    std::optional<PreintegratedImu> motion;
    std::optional<GyroscopeIntegral> rotation;     // where there is no accelerometer to trust
    std::optional<Eigen::Quaterniond> q_ahrs_imu;  // in the AHRS's own world, z up
    std::optional<double> depth_m;                 // below some surface
};

// What the dive's inertial sensors say: about orientation the gyroscope where there is one, else
// the AHRS (with the pairwise estimator, as the paper has it, the AHRS first); about motion
// gyroscope and accelerometer. Biases are learnt from vision as the dive goes on.
class InertialPrior {
public:
    InertialPrior(const types::Recording& recording, const ReconstructionOptions& options);

    // From now on the samples are taken for what a unit that sits as calibrated would have said.
    void align(const types::ImuAlignment& alignment);

    bool has_gyroscope() const { return gyroscope_; }
    bool has_accelerometer() const { return accelerometer_; }
    bool has_ahrs() const { return ahrs_; }
    bool has_pressure() const { return pressure_; }

    // q_from_to of the body. Nothing when no sensor covers the interval.
    std::optional<types::KnownRotation> rotation(std::int64_t from_ns, std::int64_t to_ns) const;
    // The same; where the AHRS leads, it is the turn from where the body is thought to be to where
    // the AHRS sees it then, so that no drift of the orientation lasts.
    std::optional<types::KnownRotation> rotation_from(const Eigen::Quaterniond& q_world_imu,
                                                      std::int64_t from_ns,
                                                      std::int64_t to_ns) const;
    std::optional<GyroscopeIntegral> integral(std::int64_t from_ns, std::int64_t to_ns) const;
    // Nothing without an accelerometer that feels gravity.
    std::optional<PreintegratedImu> motion(std::int64_t from_ns, std::int64_t to_ns) const;
    // q_ahrs_imu by the AHRS, interpolated.
    std::optional<Eigen::Quaterniond> absolute(std::int64_t time_ns) const;
    // By the pressure, interpolated.
    std::optional<double> depth_m(std::int64_t time_ns) const;
    // All of these; with `from_ns` == `to_ns` those of the moment alone.
    SensorReadings readings(std::int64_t from_ns, std::int64_t to_ns) const;
    // q_world_imu, z up: by the AHRS; else by the accelerometer over the second that follows, the
    // camera looking along x; without either the camera is taken to be held level.
    Eigen::Quaterniond initial_orientation(std::int64_t time_ns,
                                           const Eigen::Matrix3d& R_imu_cam) const;

    // Vision saw the body turn by `seen` over the interval.
    void learn_bias(std::int64_t from_ns, std::int64_t to_ns, const Eigen::Quaterniond& seen);
    void set_bias(const ImuBias& bias, double gyroscope_sigma);
    const ImuBias& bias() const { return bias_; }
    // As it is on a diver: white noise larger than the data sheet's.
    const types::ImuNoise& noise() const { return noise_; }

private:
    const types::Recording& recording_;
    std::vector<types::ImuSample> imu_;
    std::vector<types::OrientationSample> orientations_;
    bool gyroscope_ = false;
    bool accelerometer_ = false;
    bool ahrs_ = false;
    bool ahrs_leads_ = false;  // over the gyroscope, as in the paper
    bool pressure_ = false;
    types::ImuNoise noise_;
    ImuBias bias_;
    double bias_sigma_ = kInitialGyroscopeBiasSigma;  // rad/s
};

}  // namespace divemesh::imu
