#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/imu/estimate_alignment.hpp"
#include "worker/imu/gyroscope_integral.hpp"
#include "worker/imu/preintegration.hpp"
#include "worker/imu/usable_samples.hpp"
#include "worker/types/known_rotation.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/sensors_left_out.hpp"

namespace divemesh::imu {

constexpr double kInitialGyroscopeBiasSigma = 0.1;      // rad/s, for a cheap sensor
constexpr double kInitialAccelerometerBiasSigma = 0.1;  // m/s^2
constexpr double kUsualDepthSigma_m = 0.02;             // of the pressure, with the waves above

// The sensors' measurements at one time, and of the motion to it from an earlier time.
struct SensorReadings {
    double interval_s = 0.0;
    std::optional<PreintegratedImu> motion;
    std::optional<GyroscopeIntegral> rotation;     // if `motion` is nullopt
    std::optional<Eigen::Quaterniond> q_ahrs_imu;  // in the AHRS's own world frame, z up
    std::optional<double> depth_m;                 // below an unknown surface level
    double depth_sigma_m = kUsualDepthSigma_m;     // independent from keyframe to keyframe
};

// The measurements of the dive's inertial sensors. Rotation comes from the gyroscope if there is
// one, else from the AHRS, unless the AHRS is to lead; motion from gyroscope and accelerometer.
// Biases are learnt from vision during the dive.
class InertialPrior {
public:
    InertialPrior(const types::Recording& recording,
                  const ReconstructionOptions& options,
                  const types::SensorsLeftOut& left_out = {});

    // Leaves out the IMU from a time on; nullopt: uses all samples again that were not left out at
    // the start.
    void leave_out_from(std::optional<std::int64_t> from_ns) { imu_ends_ns_ = from_ns; }

    // Leaves out the IMU over every interval that shares time with this one, which vision
    // contradicts. Intervals are added in order.
    void leave_out(const types::TimeInterval& time) { contradicted_.push_back(time); }

    // Takes rotations from the AHRS where there is one, before the gyroscope, as the paper does.
    void let_ahrs_lead() { ahrs_leads_ = true; }

    // Takes in the RMS error of the pressure's changes over five seconds, as vision judged them.
    // Waves and a slow sensor err alike for seconds, so that neighbours in time do not average out.
    void set_pressure_error(double error_m) { pressure_error_m_ = error_m; }

    // Corrects all samples for `alignment`, as if the IMU were mounted as calibrated.
    void align(const types::ImuAlignment& alignment);

    // Returns the usable samples as recorded, on the IMU's clock.
    const std::vector<types::ImuSample>& rates() const { return rates_; }
    bool has_gyroscope() const { return gyroscope_; }
    bool has_accelerometer() const { return accelerometer_; }
    bool has_pressure() const { return pressure_; }

    // Returns q_from_to of the body; nullopt if no sensor covers the interval.
    std::optional<types::KnownRotation> rotation(std::int64_t from_ns, std::int64_t to_ns) const;
    // The same. If the AHRS leads, it is the rotation from the estimated orientation
    // `q_world_imu` to that of the AHRS at `to_ns`, so that orientation drift does not last.
    std::optional<types::KnownRotation> rotation_from(const Eigen::Quaterniond& q_world_imu,
                                                      std::int64_t from_ns,
                                                      std::int64_t to_ns) const;
    // Returns the gyroscope's integral; nullopt without a gyroscope that covers the interval, or
    // over more than eight seconds.
    std::optional<GyroscopeIntegral> integral(std::int64_t from_ns, std::int64_t to_ns) const;
    // Returns the preintegrated motion; nullopt without an accelerometer that measures gravity, or
    // over more than eight seconds.
    std::optional<PreintegratedImu> motion(std::int64_t from_ns, std::int64_t to_ns) const;
    // Returns q_ahrs_imu, interpolated; nullopt without an AHRS or in a gap.
    std::optional<Eigen::Quaterniond> absolute(std::int64_t time_ns) const;
    // Returns the depth from the pressure, m, interpolated; nullopt without a sensor or in a gap.
    std::optional<double> depth_m(std::int64_t time_ns) const;
    // Returns true if a sensor measures which way is up at a time, or in the second from it on.
    // Otherwise initial_orientation() is a guess.
    bool knows_vertical(std::int64_t time_ns) const;
    // Returns all of these; if `from_ns` == `to_ns`, those of the single time only.
    SensorReadings readings(std::int64_t from_ns, std::int64_t to_ns) const;
    // Returns q_world_imu, z up: from the AHRS, else from the accelerometer over the following
    // second with the camera looking along x. Without either the camera is assumed to be level.
    Eigen::Quaterniond initial_orientation(std::int64_t time_ns,
                                           const Eigen::Matrix3d& R_imu_cam) const;

    // Updates the gyroscope bias, given the rotation `seen` from vision over the interval.
    void learn_bias(std::int64_t from_ns, std::int64_t to_ns, const Eigen::Quaterniond& seen);
    // Sets the gyroscope bias to its mean error over some seconds, at most eight, in which the rig
    // hardly moved: the rotation `seen` from vision has the noise of one pose alone.
    void learn_bias_at_rest(std::int64_t from_ns,
                            std::int64_t to_ns,
                            const Eigen::Quaterniond& seen);
    void set_bias(const ImuBias& bias, double gyroscope_sigma);
    const ImuBias& bias() const { return bias_; }
    // Returns the noise on a diver: white noise larger than the data sheet's, and at least what the
    // samples show.
    const types::ImuNoise& noise() const { return noise_; }

private:
    // Returns the direction of the specific force over the second from a time on, in the body at
    // that time; nullopt without usable samples of gravity in it.
    std::optional<Eigen::Vector3d> measured_up(std::int64_t time_ns) const;
    bool imu_is_used(std::int64_t from_ns, std::int64_t to_ns) const;
    double depth_sigma_m(double interval_s) const;

    const types::Recording& recording_;
    std::optional<std::int64_t> imu_ends_ns_;
    std::vector<types::TimeInterval> contradicted_;
    std::vector<types::ImuSample> rates_;                        // usable, as recorded
    std::vector<types::ImuSample> imu_;                          // aligned
    std::vector<types::OrientationSample> usable_orientations_;  // likewise
    std::vector<types::OrientationSample> orientations_;         // aligned
    bool gyroscope_ = false;
    bool accelerometer_ = false;
    bool ahrs_ = false;
    bool ahrs_leads_ = false;
    bool pressure_ = false;
    double pressure_error_m_ = 0.0;
    types::ImuNoise noise_;
    ImuBias bias_;
    double bias_sigma_ = kInitialGyroscopeBiasSigma;  // rad/s
};

}  // namespace divemesh::imu
