#include "worker/video/plan_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "worker/base/seconds.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::video {
namespace {

constexpr double kMaxGapPeriods = 0.6;  // nearest frames of a steady video are half a period apart
constexpr double kEveryFrame = 0.75;    // of the video's rate: above it, choosing would only jitter

std::int64_t median_period_ns(const std::vector<std::int64_t>& stamps_ns) {
    std::vector<std::int64_t> periods_ns;
    for (std::size_t i = 1; i < stamps_ns.size(); ++i)
        periods_ns.push_back(stamps_ns[i] - stamps_ns[i - 1]);
    return stats::upper_median(std::move(periods_ns));
}

// Returns the place of the stamp that is nearest to a time, the earlier one of two.
std::size_t nearest(const std::vector<std::int64_t>& stamps_ns, std::int64_t time_ns) {
    const auto after = std::lower_bound(stamps_ns.begin(), stamps_ns.end(), time_ns);
    if (after == stamps_ns.begin()) return 0;
    const auto place = static_cast<std::size_t>(after - stamps_ns.begin());
    if (after == stamps_ns.end() || time_ns - *(after - 1) <= *after - time_ns) return place - 1;
    return place;
}

// Returns the largest gap between the frames of a pair. A video of one frame has no period.
std::int64_t max_gap_ns(const std::vector<std::int64_t>& left_ns,
                        const std::vector<std::int64_t>& right_ns,
                        double rate_hz) {
    const std::int64_t period_ns = std::max(median_period_ns(left_ns), median_period_ns(right_ns));
    const double slowest_ns = period_ns > 0 ? static_cast<double>(period_ns) : 1e9 / rate_hz;
    return std::llround(kMaxGapPeriods * slowest_ns);
}

// Returns the frames of the left video that are nearest to the moments of the rate, which begin at
// one of them; all of them if the rate is about that of the video or above it.
std::vector<std::int64_t> at_rate(const std::vector<std::int64_t>& left_ns, double rate_hz) {
    const double period_s = base::to_s(median_period_ns(left_ns));
    if (left_ns.empty() || rate_hz * period_s >= kEveryFrame) return left_ns;
    std::vector<std::int64_t> chosen;
    const double whole_s = base::to_s(left_ns.back() - left_ns.front());
    const double last_moment = std::floor((whole_s + 0.5 * period_s) * rate_hz);
    double chosen_moment = -1.0;
    double chosen_off = 0.0;  // of the chosen frame from its moment, in moments
    for (const std::int64_t stamp_ns : left_ns) {
        const double passed = base::to_s(stamp_ns - left_ns.front()) * rate_hz;
        const double off = std::abs(passed - std::round(passed));
        if (std::round(passed) > last_moment) break;
        const bool is_new = std::round(passed) > chosen_moment;
        if (!is_new && off >= chosen_off) continue;
        if (!is_new) chosen.pop_back();
        chosen.push_back(stamp_ns);
        chosen_moment = std::round(passed);
        chosen_off = off;
    }
    return chosen;
}

}  // namespace

std::vector<PlannedPair> plan_pairs(const std::vector<std::int64_t>& left_ns,
                                    const std::vector<std::int64_t>& right_ns,
                                    const ClockOffset& clock,
                                    double rate_hz) {
    std::vector<PlannedPair> pairs;
    if (left_ns.empty() || right_ns.empty()) return pairs;
    std::vector<std::int64_t> as_left_ns;  // the right stamps by the left clock
    as_left_ns.reserve(right_ns.size());
    for (const std::int64_t stamp_ns : right_ns) as_left_ns.push_back(clock.left_ns(stamp_ns));
    const std::int64_t gap_ns = max_gap_ns(left_ns, right_ns, rate_hz);
    std::vector<std::int64_t> common_ns;
    for (const std::int64_t stamp_ns : left_ns)
        if (stamp_ns >= as_left_ns.front() - gap_ns && stamp_ns <= as_left_ns.back() + gap_ns)
            common_ns.push_back(stamp_ns);
    std::size_t next_right = 0;
    for (const std::int64_t stamp_ns : at_rate(common_ns, rate_hz)) {
        const std::size_t right = nearest(as_left_ns, stamp_ns);
        if (right < next_right || std::abs(as_left_ns[right] - stamp_ns) > gap_ns) continue;
        pairs.push_back({stamp_ns, right_ns[right]});
        next_right = right + 1;
    }
    return pairs;
}

PairTimes times_between(const std::vector<PlannedPair>& pairs, const ClockOffset& clock) {
    std::vector<double> times_s;
    times_s.reserve(pairs.size());
    PairTimes between;
    for (const PlannedPair& pair : pairs) {
        times_s.push_back(std::abs(base::to_s(clock.left_ns(pair.right_ns) - pair.left_ns)));
        between.max_s = std::max(between.max_s, times_s.back());
    }
    between.median_s = stats::median(std::move(times_s));
    return between;
}

}  // namespace divemesh::video
