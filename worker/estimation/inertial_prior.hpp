#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "schemas/reconstruction_options.hpp"
#include "worker/estimation/gyroscope_integral.hpp"
#include "worker/recording.hpp"
#include "worker/steps/predict_orientation.hpp"

namespace divemesh::worker {

// What the dive's inertial sensors say about orientation: the gyroscope where there is one, else
// the AHRS. The gyroscope's bias is learnt from vision as the dive goes on.
class InertialPrior {
public:
    InertialPrior(const Recording& recording, const ReconstructionOptions& options);

    bool has_gyroscope() const { return gyroscope_; }
    bool has_ahrs() const { return ahrs_; }

    // q_from_to of the body. Nothing when no sensor covers the interval.
    std::optional<KnownRotation> turn(std::int64_t from_ns, std::int64_t to_ns) const;
    std::optional<GyroscopeIntegral> integral(std::int64_t from_ns, std::int64_t to_ns) const;
    // q_world_imu by the AHRS, interpolated.
    std::optional<Eigen::Quaterniond> absolute(std::int64_t time_ns) const;
    // q_world_imu, z up: by the AHRS; else by the accelerometer over the second that follows, the
    // camera looking along x; without either the camera is taken to be held level.
    Eigen::Quaterniond initial_orientation(std::int64_t time_ns,
                                           const Eigen::Matrix3d& R_imu_cam) const;

    // Vision saw the body turn by `seen` over the interval.
    void learn_bias(std::int64_t from_ns, std::int64_t to_ns, const Eigen::Quaterniond& seen);
    void set_bias(const Eigen::Vector3d& bias, double sigma);
    const Eigen::Vector3d& bias() const { return bias_; }
    double gyroscope_random_walk() const { return noise_.gyroscope_random_walk; }

private:
    const Recording& recording_;
    bool gyroscope_ = false;
    bool ahrs_ = false;
    ImuNoise noise_;
    Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();  // rad/s
    double bias_sigma_ = 0.02;                        // rad/s, of a cheap gyroscope at first
};

}  // namespace divemesh::worker
