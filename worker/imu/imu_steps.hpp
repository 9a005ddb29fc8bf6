#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/base/seconds.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::imu {

// The reasons why samples cannot be integrated over an interval.
enum class ImuFailure {
    NotCovered,  // the interval is empty, or the samples do not cover it
    Gap,         // two samples in it are more than kMaxImuGap_ns apart
};

constexpr std::int64_t kMaxImuGap_ns = 100'000'000;

// Returns the sample at `time_ns`, interpolated linearly.
inline types::ImuSample interpolate(const types::ImuSample& before,
                                    const types::ImuSample& after,
                                    std::int64_t time_ns) {
    const double share = static_cast<double>(time_ns - before.timestamp_ns) /
                         static_cast<double>(after.timestamp_ns - before.timestamp_ns);
    types::ImuSample sample;
    sample.timestamp_ns = time_ns;
    sample.angular_velocity_imu =
        before.angular_velocity_imu +
        share * (after.angular_velocity_imu - before.angular_velocity_imu);
    sample.acceleration_imu =
        before.acceleration_imu + share * (after.acceleration_imu - before.acceleration_imu);
    return sample;
}

// Calls visit(begin, end, duration_s) for every interval between neighbouring samples from
// `from_ns` to `to_ns`; the samples at both ends are interpolated. Uses the timestamps only, not
// the nominal rate. Returns the failure, or nullopt.
template <typename Visit>
std::optional<ImuFailure> for_each_step(const std::vector<types::ImuSample>& samples,
                                        std::int64_t from_ns,
                                        std::int64_t to_ns,
                                        const Visit& visit) {
    if (to_ns <= from_ns || samples.size() < 2 || samples.front().timestamp_ns > from_ns ||
        samples.back().timestamp_ns < to_ns)
        return ImuFailure::NotCovered;
    auto after = std::upper_bound(samples.begin(),
                                  samples.end(),
                                  from_ns,
                                  [](std::int64_t time_ns, const types::ImuSample& sample) {
                                      return time_ns < sample.timestamp_ns;
                                  });
    for (std::int64_t time_ns = from_ns; time_ns < to_ns; ++after) {
        const types::ImuSample& before = *(after - 1);
        if (after->timestamp_ns - before.timestamp_ns > kMaxImuGap_ns) return ImuFailure::Gap;
        const std::int64_t end_ns = std::min(after->timestamp_ns, to_ns);
        visit(interpolate(before, *after, time_ns),
              interpolate(before, *after, end_ns),
              base::to_s(end_ns - time_ns));
        time_ns = end_ns;
    }
    return std::nullopt;
}

}  // namespace divemesh::imu
