#include "sensor/rate_meter.hpp"

#include <algorithm>

namespace divemesh::sensor {
namespace {

constexpr std::chrono::seconds kMemory{20};
constexpr std::chrono::milliseconds kShortest{5};  // answers that came at once say nothing

}  // namespace

void RateMeter::answered(Clock::time_point now, Clock::time_point sent_at, std::int64_t num_bytes) {
    const auto begin = std::max(sent_at, last_answer_at_);
    last_answer_at_ = now;
    const std::chrono::duration<double> took = std::max<Clock::duration>(now - begin, kShortest);
    samples_.emplace_back(now, static_cast<double>(num_bytes) / took.count());
    while (samples_.front().first + kMemory < now) samples_.pop_front();
}

double RateMeter::bytes_per_s(Clock::time_point now) const {
    double most = 0.0;
    for (const auto& [at, rate] : samples_)
        if (at + kMemory >= now) most = std::max(most, rate);
    return most;
}

}  // namespace divemesh::sensor
