#include "worker/dive/imu_zeros.hpp"

#include <algorithm>
#include <cstdint>

namespace divemesh::dive {
namespace {

constexpr std::int64_t kMaxInterpolated_ns = 50'000'000;  // half a swing of a diver's fastest shake
constexpr double kTurning_rad_s = 0.01;  // above the noise of any gyroscope at rest

using Samples = std::vector<types::ImuSample>;

bool has_acceleration(const types::ImuSample& sample) { return !sample.acceleration_imu.isZero(0); }
bool has_rate(const types::ImuSample& sample) { return !sample.angular_velocity_imu.isZero(0); }

// Returns which rows lack the gyroscope: runs of zeros between rows that rotate.
std::vector<bool> rows_without_rate(const Samples& samples) {
    std::vector<bool> is_missing(samples.size(), false);
    const auto turns = [&](std::size_t i) {
        return samples[i].angular_velocity_imu.norm() > kTurning_rad_s;
    };
    for (std::size_t begin = 0; begin < samples.size();) {
        std::size_t end = begin;
        while (end < samples.size() && !has_rate(samples[end])) ++end;
        const bool is_bounded = begin > 0 && end < samples.size();
        if (end > begin && is_bounded && turns(begin - 1) && turns(end))
            std::fill(is_missing.begin() + static_cast<std::ptrdiff_t>(begin),
                      is_missing.begin() + static_cast<std::ptrdiff_t>(end),
                      true);
        begin = std::max(end, begin + 1);
    }
    return is_missing;
}

// Fills the accelerations between rows `before` and `after`, which have one. Returns how many.
std::int64_t interpolate(Samples& samples, std::size_t before, std::size_t after) {
    const types::ImuSample& a = samples[before];
    const types::ImuSample& b = samples[after];
    const std::int64_t duration_ns = b.timestamp_ns - a.timestamp_ns;
    if (duration_ns > kMaxInterpolated_ns) return 0;
    for (std::size_t i = before + 1; i < after; ++i) {
        const double share = static_cast<double>(samples[i].timestamp_ns - a.timestamp_ns) /
                             static_cast<double>(duration_ns);
        samples[i].acceleration_imu =
            (1.0 - share) * a.acceleration_imu + share * b.acceleration_imu;
    }
    return static_cast<std::int64_t>(after - before - 1);
}

// Fills missing accelerations where measured ones are near on both sides. Returns how many.
std::int64_t fill_accelerations(Samples& samples) {
    std::vector<std::size_t> measured;
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (has_acceleration(samples[i])) measured.push_back(i);
    std::int64_t num_filled = 0;
    for (std::size_t k = 1; k < measured.size(); ++k)
        num_filled += interpolate(samples, measured[k - 1], measured[k]);
    return num_filled;
}

}  // namespace

void fill_zero_readings(Samples& samples, const std::string& file, FindingLog& findings) {
    const bool is_measured = std::any_of(samples.begin(), samples.end(), has_acceleration);
    if (!is_measured) return;  // the check of the units reports it
    const std::vector<bool> lacks_rate = rows_without_rate(samples);
    const auto num_rows = samples.size();
    const std::int64_t num_filled = fill_accelerations(samples);
    Samples kept;
    kept.reserve(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (!lacks_rate[i] && has_acceleration(samples[i])) kept.push_back(samples[i]);
    const auto num_left_out = static_cast<std::int64_t>(num_rows - kept.size());
    samples = std::move(kept);
    if (num_filled + num_left_out == 0) return;
    findings.warning(
        "imu_zeros",
        file,
        "rotation rates are empty or exactly 0 although the rig rotates, or accelerations although "
        "gravity is never 0: " +
            std::to_string(num_left_out) + " of " + std::to_string(num_rows) +
            " rows are left out, and " + std::to_string(num_filled) +
            " accelerations are interpolated",
        "Write only rows with both readings, the accelerometer interpolated at the "
        "times of the gyroscope.");
}

}  // namespace divemesh::dive
