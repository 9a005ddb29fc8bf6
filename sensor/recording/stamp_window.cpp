#include "sensor/recording/stamp_window.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "worker/stats/median.hpp"

namespace divemesh::sensor {
namespace {

constexpr std::size_t kMaxStamps = 64;
constexpr std::size_t kMinStamps = 5;  // needed for a rate

}  // namespace

std::int64_t StampWindow::add(std::int64_t timestamp_ns) {
    std::int64_t num_missing = 0;
    if (!stamps_ns_.empty()) {
        const double step =
            static_cast<double>(timestamp_ns) - static_cast<double>(stamps_ns_.back());
        if (step <= 0.0) return 0;
        if (const auto period = period_ns()) num_missing = std::llround(step / *period) - 1;
    }
    stamps_ns_.push_back(timestamp_ns);
    if (stamps_ns_.size() > kMaxStamps) stamps_ns_.pop_front();
    return std::max<std::int64_t>(num_missing, 0);
}

std::optional<double> StampWindow::period_ns() const {
    if (stamps_ns_.size() < kMinStamps) return std::nullopt;
    std::vector<std::int64_t> steps;
    for (std::size_t i = 1; i < stamps_ns_.size(); ++i)
        steps.push_back(stamps_ns_[i] - stamps_ns_[i - 1]);
    return static_cast<double>(stats::upper_median(std::move(steps)));
}

std::optional<double> StampWindow::rate_hz() const {
    if (stamps_ns_.size() < kMinStamps) return std::nullopt;
    const auto span = static_cast<double>(stamps_ns_.back() - stamps_ns_.front());
    return static_cast<double>(stamps_ns_.size() - 1) * 1e9 / span;
}

std::optional<std::int64_t> StampWindow::newest_ns() const {
    if (stamps_ns_.empty()) return std::nullopt;
    return stamps_ns_.back();
}

}  // namespace divemesh::sensor
