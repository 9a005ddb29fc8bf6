#include "worker/simulator/inertial_sensors.hpp"

#include <cmath>

#include "worker/base/angle.hpp"
#include "worker/base/hashed_random.hpp"
#include "worker/simulator/sensor_samples.hpp"

namespace divemesh::simulator {
std::vector<ImuRecord> simulate_imu(const DiverMotion& motion,
                                    double duration_s,
                                    const types::ImuNoise* noise,
                                    std::uint64_t seed) {
    base::RandomRow random(base::hash64(seed, 0x696d75ULL));
    Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();
    Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();
    if (noise) {
        gyroscope_bias = 0.006 * gaussian3(random);
        accelerometer_bias = 0.04 * gaussian3(random);
    }
    // Converts white noise density to the deviation per sample, and random walk to the deviation
    // per step.
    const double white = std::sqrt(kImuRateHz);
    const double walk = std::sqrt(1.0 / kImuRateHz);
    std::vector<ImuRecord> records;
    for_each_sample(kImuRateHz, duration_s, [&](double t_s, std::int64_t timestamp_ns) {
        ImuRecord record{.sample = {.timestamp_ns = timestamp_ns},
                         .truth = motion.at(t_s),
                         .gyroscope_bias = gyroscope_bias,
                         .accelerometer_bias = accelerometer_bias};
        const Eigen::Matrix3d R_imu_world = record.truth.T_world_imu.linear().transpose();
        record.sample.angular_velocity_imu = record.truth.angular_velocity_imu + gyroscope_bias;
        record.sample.acceleration_imu =
            R_imu_world * (record.truth.acceleration_world + Eigen::Vector3d(0, 0, kGravity)) +
            accelerometer_bias;
        if (noise) {
            record.sample.angular_velocity_imu +=
                noise->gyroscope_noise_density * white * gaussian3(random);
            record.sample.acceleration_imu +=
                noise->accelerometer_noise_density * white * gaussian3(random);
            gyroscope_bias += noise->gyroscope_random_walk * walk * gaussian3(random);
            accelerometer_bias += noise->accelerometer_random_walk * walk * gaussian3(random);
        }
        records.push_back(record);
    });
    return records;
}

std::vector<types::OrientationSample> simulate_ahrs(const DiverMotion& motion,
                                                    double duration_s,
                                                    bool noise,
                                                    std::uint64_t seed) {
    base::RandomRow random(base::hash64(seed, 0x61687273ULL));
    const GaussMarkovProcess tilt_x(random, 12.0);
    const GaussMarkovProcess tilt_y(random, 12.0);
    const GaussMarkovProcess heading(random, 25.0);
    const double rms = noise ? random.uniform(0.3, 0.5) * base::kRadPerDeg / std::sqrt(3.0) : 0.0;
    const double white = noise ? 0.02 * base::kRadPerDeg : 0.0;
    std::vector<types::OrientationSample> samples;
    for_each_sample(kAhrsRateHz, duration_s, [&](double t_s, std::int64_t timestamp_ns) {
        const Eigen::Vector3d error =
            rms * Eigen::Vector3d(tilt_x.at(t_s), tilt_y.at(t_s), heading.at(t_s)) +
            white * gaussian3(random);
        const double angle = error.norm();
        const Eigen::Vector3d axis =
            angle > 0.0 ? Eigen::Vector3d(error / angle) : Eigen::Vector3d::UnitX();
        samples.push_back({timestamp_ns,
                           Eigen::AngleAxisd(angle, axis) *
                               Eigen::Quaterniond(motion.at(t_s).T_world_imu.linear())});
    });
    return samples;
}

std::vector<types::PressureSample> simulate_pressure(const DiverMotion& motion,
                                                     double duration_s,
                                                     double surface_z_m,
                                                     bool noise,
                                                     std::uint64_t seed) {
    base::RandomRow random(base::hash64(seed, 0x7072657373ULL));
    std::vector<types::PressureSample> samples;
    for_each_sample(kPressureRateHz, duration_s, [&](double t_s, std::int64_t timestamp_ns) {
        const double error_m = noise ? 0.005 * random.gaussian() : 0.0;
        samples.push_back(
            {timestamp_ns, surface_z_m - motion.at(t_s).T_world_imu.translation().z() + error_m});
    });
    return samples;
}

}  // namespace divemesh::simulator
