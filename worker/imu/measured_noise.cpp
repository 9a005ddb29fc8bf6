#include "worker/imu/measured_noise.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "worker/base/seconds.hpp"
#include "worker/imu/imu_steps.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::imu {
namespace {

constexpr double kGyroscopeInflation = 1.5;
constexpr double kAccelerometerInflation = 5.0;
constexpr std::size_t kMinSamples = 30;
constexpr std::int64_t kBin_ns = 1'000'000'000;

// The sum of the squared noise densities of a second of samples.
struct Bin {
    std::int64_t from_ns = 0;
    double sum = 0.0;
    double num = 0.0;
};

// Returns the squared noise density, per axis, that three samples show: by how far the one in the
// middle lies from the line through the others.
template <typename Values>
double squared_density(const types::ImuSample& a,
                       const types::ImuSample& b,
                       const types::ImuSample& c,
                       const Values& values) {
    const double whole_s = base::to_s(c.timestamp_ns - a.timestamp_ns);
    const double share = base::to_s(b.timestamp_ns - a.timestamp_ns) / whole_s;
    const Eigen::Vector3d distance = values(b) - (1.0 - share) * values(a) - share * values(c);
    const double times_noise = 1.0 + share * share + (1.0 - share) * (1.0 - share);
    return distance.squaredNorm() / (3.0 * times_noise) * 0.5 * whole_s;
}

// Returns the noise density, per axis: the median over seconds.
template <typename Values>
double density(const std::vector<types::ImuSample>& samples, const Values& values) {
    std::vector<double> squares;
    Bin bin{samples.front().timestamp_ns};
    for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
        const types::ImuSample& a = samples[i - 1];
        const types::ImuSample& c = samples[i + 1];
        const std::int64_t whole_ns = c.timestamp_ns - a.timestamp_ns;
        if (whole_ns > 0 && whole_ns <= 2 * kMaxImuGap_ns) {
            bin.sum += squared_density(a, samples[i], c, values);
            bin.num += 1.0;
        }
        if (c.timestamp_ns - bin.from_ns < kBin_ns) continue;
        if (bin.num > 0.0) squares.push_back(bin.sum / bin.num);
        bin = {c.timestamp_ns};
    }
    if (squares.empty()) return 0.0;
    return std::sqrt(stats::upper_median(std::move(squares)));
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
    noise.gyroscope_noise_density = std::max(
        noise.gyroscope_noise_density,
        density(samples, [](const types::ImuSample& s) { return s.angular_velocity_imu; }));
    noise.accelerometer_noise_density =
        std::max(noise.accelerometer_noise_density,
                 density(samples, [](const types::ImuSample& s) { return s.acceleration_imu; }));
    return noise;
}

}  // namespace divemesh::imu
