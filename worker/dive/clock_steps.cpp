#include "worker/dive/clock_steps.hpp"

#include <algorithm>

#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr std::size_t kMaxSteps = 5;     // more descents are a table that is not sorted
constexpr std::size_t kMinRunRows = 10;  // between two steps
constexpr std::int64_t kMaxShift_ns = 1'000'000'000'000'000'000;  // 31 years; sums stay in range
constexpr double kHolePeriods = 1.5;   // a longer interval has room for a row
constexpr double kJointPeriods = 5.0;  // blocks this close continue each other

using Stamps = std::span<const std::int64_t>;

std::vector<std::size_t> descents(Stamps stamps) {
    std::vector<std::size_t> rows;
    for (std::size_t i = 1; i < stamps.size(); ++i)
        if (stamps[i] < stamps[i - 1]) rows.push_back(i);
    return rows;
}

std::int64_t median_rise_ns(Stamps stamps) {
    std::vector<std::int64_t> rises;
    rises.reserve(stamps.size());
    for (std::size_t i = 1; i < stamps.size(); ++i)
        if (stamps[i] > stamps[i - 1]) rises.push_back(stamps[i] - stamps[i - 1]);
    return stats::upper_median(std::move(rises));
}

bool is_within(std::int64_t interval_ns, double periods, std::int64_t period_ns) {
    return static_cast<double>(interval_ns) <= periods * static_cast<double>(period_ns);
}

// Returns whether a later row may belong between the sorted rows of `before`.
bool has_room(Stamps before, std::int64_t stamp_ns, std::int64_t period_ns) {
    const auto next = std::lower_bound(before.begin(), before.end(), stamp_ns);
    if (next == before.end()) return true;
    if (*next == stamp_ns) return false;
    if (next == before.begin()) return is_within(*next - stamp_ns, kJointPeriods, period_ns);
    return !is_within(*next - *(next - 1), kHolePeriods, period_ns);
}

bool is_step(Stamps before, Stamps after, std::int64_t period_ns) {
    if (before.size() < kMinRunRows || after.size() < kMinRunRows) return false;
    const bool continue_each_other =
        after.back() < before.front() &&
        is_within(before.front() - after.back(), kJointPeriods, period_ns);
    if (continue_each_other) return false;
    const auto displaced_end = std::lower_bound(after.begin(), after.end(), before.back());
    const auto num_fitting = std::count_if(after.begin(), displaced_end, [&](std::int64_t t) {
        return has_room(before, t, period_ns);
    });
    return num_fitting * 2 <= displaced_end - after.begin();
}

}  // namespace

TableClock find_clock_steps(Stamps stamps) {
    TableClock clock;
    clock.period_ns = median_rise_ns(stamps);
    const std::vector<std::size_t> rows = descents(stamps);
    if (rows.size() > kMaxSteps) return clock;
    std::size_t begin = 0;
    std::int64_t shift_ns = 0;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const std::size_t row = rows[k];
        const std::size_t end = k + 1 < rows.size() ? rows[k + 1] : stamps.size();
        if (!is_step(stamps.subspan(begin, row - begin),
                     stamps.subspan(row, end - row),
                     clock.period_ns))
            return {clock.period_ns, {}};
        shift_ns += stamps[row - 1] + clock.period_ns - stamps[row];
        if (shift_ns > kMaxShift_ns) return {clock.period_ns, {}};
        clock.steps.push_back({row, stamps[row - 1], stamps[row], shift_ns});
        begin = row;
    }
    return clock;
}

}  // namespace divemesh::dive
