#include "worker/dive/imu_frozen.hpp"

#include <algorithm>
#include <cstdint>

namespace divemesh::dive {
namespace {

constexpr std::size_t kMinRows = 10;
constexpr std::int64_t kMinDuration_ns = 100'000'000;

bool repeats(const types::ImuSample& before, const types::ImuSample& now) {
    return now.angular_velocity_imu == before.angular_velocity_imu &&
           now.acceleration_imu == before.acceleration_imu;
}

// Returns which rows belong to a run that repeats its first row, that one excepted.
std::vector<bool> frozen_rows(const std::vector<types::ImuSample>& samples) {
    std::vector<bool> is_frozen(samples.size(), false);
    for (std::size_t begin = 0; begin < samples.size();) {
        std::size_t end = begin + 1;
        while (end < samples.size() && repeats(samples[begin], samples[end])) ++end;
        const std::int64_t duration_ns =
            samples[end - 1].timestamp_ns - samples[begin].timestamp_ns;
        if (end - begin > kMinRows && duration_ns >= kMinDuration_ns)
            std::fill(is_frozen.begin() + static_cast<std::ptrdiff_t>(begin + 1),
                      is_frozen.begin() + static_cast<std::ptrdiff_t>(end),
                      true);
        begin = end;
    }
    return is_frozen;
}

}  // namespace

void leave_out_frozen_readings(std::vector<types::ImuSample>& samples,
                               const std::string& file,
                               FindingLog& findings) {
    const std::vector<bool> is_frozen = frozen_rows(samples);
    const auto num_frozen = std::count(is_frozen.begin(), is_frozen.end(), true);
    if (num_frozen == 0 || 2 * num_frozen > std::ssize(samples)) return;
    const auto first = static_cast<std::size_t>(
        std::find(is_frozen.begin(), is_frozen.end(), true) - is_frozen.begin());
    findings.warning("imu_frozen",
                     file,
                     std::to_string(num_frozen) + " of " + std::to_string(samples.size()) +
                         " rows repeat all readings of the row before, from timestamp " +
                         std::to_string(samples[first].timestamp_ns) +
                         " on: the sensor or its connection had hung. They are left out",
                     "Check cable, power and driver of the IMU.");
    std::vector<types::ImuSample> kept;
    kept.reserve(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (!is_frozen[i]) kept.push_back(samples[i]);
    samples = std::move(kept);
}

}  // namespace divemesh::dive
