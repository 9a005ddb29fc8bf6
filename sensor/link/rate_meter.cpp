#include "sensor/link/rate_meter.hpp"

#include <algorithm>

namespace divemesh::sensor {
namespace {

constexpr std::chrono::seconds kMemory{20};
constexpr std::chrono::milliseconds kMinInterval{5};  // shorter intervals give no rate

}  // namespace

RateMeter::Stamp RateMeter::sent(Clock::time_point now, bool is_idle) {
    if (is_idle) answered_.at = now;
    return answered_;
}

void RateMeter::answered(Clock::time_point now, const Stamp& last, std::int64_t num_bytes) {
    answered_.num_bytes += num_bytes;
    answered_.at = now;
    const std::chrono::duration<double> took =
        std::max<Clock::duration>(now - last.at, kMinInterval);
    samples_.emplace_back(now,
                          static_cast<double>(answered_.num_bytes - last.num_bytes) / took.count());
    while (samples_.front().first + kMemory < now) samples_.pop_front();
}

double RateMeter::bytes_per_s(Clock::time_point now) const {
    double max_rate = 0.0;
    for (const auto& [at, rate] : samples_)
        if (at + kMemory >= now) max_rate = std::max(max_rate, rate);
    return max_rate;
}

}  // namespace divemesh::sensor
