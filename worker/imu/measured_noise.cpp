#include "worker/imu/measured_noise.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "worker/base/seconds.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::imu {
namespace {

constexpr double kGyroscopeInflation = 1.5;
constexpr double kAccelerometerInflation = 5.0;
constexpr std::size_t kMinSamples = 30;
constexpr std::int64_t kBin_ns = 1'000'000'000;
constexpr double kOfSecondDifference = 6.0;  // variance of x - 2 y + z of white noise

// Returns the median interval between samples.
double interval_s(const std::vector<types::ImuSample>& samples) {
    std::vector<double> intervals_s;
    intervals_s.reserve(samples.size());
    for (std::size_t i = 1; i < samples.size(); ++i)
        intervals_s.push_back(base::to_s(samples[i].timestamp_ns - samples[i - 1].timestamp_ns));
    return stats::upper_median(std::move(intervals_s));
}

// Returns the noise density of `values`, per axis: the median over seconds.
double density(const std::vector<types::ImuSample>& samples,
               Eigen::Vector3d types::ImuSample::*values,
               double interval_s) {
    std::vector<double> variances;
    double squares = 0.0;
    std::size_t num = 0;
    std::int64_t from_ns = samples.front().timestamp_ns;
    for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
        const Eigen::Vector3d second_difference =
            samples[i - 1].*values - 2.0 * samples[i].*values + samples[i + 1].*values;
        squares += second_difference.squaredNorm() / (3.0 * kOfSecondDifference);
        ++num;
        if (samples[i + 1].timestamp_ns - from_ns < kBin_ns) continue;
        variances.push_back(squares / static_cast<double>(num));
        from_ns = samples[i + 1].timestamp_ns;
        squares = 0.0;
        num = 0;
    }
    if (variances.empty()) return 0.0;
    return std::sqrt(stats::upper_median(std::move(variances)) * interval_s);
}

}  // namespace

types::ImuNoise on_a_diver(const types::ImuNoise& data_sheet) {
    types::ImuNoise noise = data_sheet;
    noise.gyroscope_noise_density *= kGyroscopeInflation;
    noise.accelerometer_noise_density *= kAccelerometerInflation;
    return noise;
}

types::ImuNoise at_least_measured(const std::vector<types::ImuSample>& samples,
                                  const types::ImuNoise& stated) {
    types::ImuNoise noise = stated;
    if (samples.size() < kMinSamples) return noise;
    const double every_s = interval_s(samples);
    noise.gyroscope_noise_density =
        std::max(noise.gyroscope_noise_density,
                 density(samples, &types::ImuSample::angular_velocity_imu, every_s));
    noise.accelerometer_noise_density =
        std::max(noise.accelerometer_noise_density,
                 density(samples, &types::ImuSample::acceleration_imu, every_s));
    return noise;
}

}  // namespace divemesh::imu
