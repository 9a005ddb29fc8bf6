#include "worker/dive/imu_frozen.hpp"

#include <algorithm>
#include <cstdint>

namespace divemesh::dive {
namespace {

constexpr std::size_t kMinRows = 10;
constexpr std::int64_t kMinDuration_ns = 100'000'000;
// One of the two sensors alone must hang for longer: a coarse one may repeat itself at rest.
constexpr std::int64_t kMinDurationOfOne_ns = 1'000'000'000;

using Samples = std::vector<types::ImuSample>;

bool rate_repeats(const types::ImuSample& before, const types::ImuSample& now) {
    return now.angular_velocity_imu == before.angular_velocity_imu;
}

bool force_repeats(const types::ImuSample& before, const types::ImuSample& now) {
    return now.acceleration_imu == before.acceleration_imu;
}

bool all_repeats(const types::ImuSample& before, const types::ImuSample& now) {
    return rate_repeats(before, now) && force_repeats(before, now);
}

// Marks the rows that belong to a run that repeats its first row, that one excepted; none if most
// rows do.
template <typename Repeats>
void mark_runs(const Samples& samples,
               const Repeats& repeats,
               std::int64_t min_duration_ns,
               std::vector<bool>& is_frozen) {
    std::vector<std::size_t> rows;
    for (std::size_t begin = 0; begin < samples.size();) {
        std::size_t end = begin + 1;
        while (end < samples.size() && repeats(samples[begin], samples[end])) ++end;
        const std::int64_t duration_ns =
            samples[end - 1].timestamp_ns - samples[begin].timestamp_ns;
        if (end - begin > kMinRows && duration_ns >= min_duration_ns)
            for (std::size_t row = begin + 1; row < end; ++row) rows.push_back(row);
        begin = end;
    }
    if (2 * rows.size() > samples.size()) return;
    for (const std::size_t row : rows) is_frozen[row] = true;
}

std::vector<bool> frozen_rows(const Samples& samples) {
    std::vector<bool> is_frozen(samples.size(), false);
    mark_runs(samples, all_repeats, kMinDuration_ns, is_frozen);
    mark_runs(samples, rate_repeats, kMinDurationOfOne_ns, is_frozen);
    mark_runs(samples, force_repeats, kMinDurationOfOne_ns, is_frozen);
    return is_frozen;
}

}  // namespace

void leave_out_frozen_readings(std::vector<types::ImuSample>& samples,
                               const std::string& file,
                               FindingLog& findings) {
    const std::vector<bool> is_frozen = frozen_rows(samples);
    const auto num_frozen = std::count(is_frozen.begin(), is_frozen.end(), true);
    if (num_frozen == 0) return;
    const auto first = static_cast<std::size_t>(
        std::find(is_frozen.begin(), is_frozen.end(), true) - is_frozen.begin());
    findings.warning(
        "imu_frozen",
        file,
        std::to_string(num_frozen) + " of " + std::to_string(samples.size()) +
            " rows repeat the readings of the row before, of gyroscope or "
            "accelerometer, from timestamp " +
            std::to_string(samples[first].timestamp_ns) +
            " on: the sensor or its connection had stopped responding. They are left out",
        "Check cable, power and driver of the IMU.");
    std::vector<types::ImuSample> kept;
    kept.reserve(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (!is_frozen[i]) kept.push_back(samples[i]);
    samples = std::move(kept);
}

}  // namespace divemesh::dive
