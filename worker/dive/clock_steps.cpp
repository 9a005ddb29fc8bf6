#include "worker/dive/clock_steps.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr std::size_t kMaxSteps = 5;     // more are a table that is not sorted
constexpr std::size_t kRowsOfLate = 50;  // so are more descents than one in so many rows
constexpr std::size_t kMaxVisits = 20;   // of each row; more of them is a table that is not sorted
constexpr std::size_t kMinRunRows = 10;  // between two steps
constexpr std::int64_t kMaxShift_ns = 1'000'000'000'000'000'000;  // 31 years; sums stay in range
constexpr double kHolePeriods = 1.5;     // a longer interval has room for a row
constexpr double kJointPeriods = 5.0;    // blocks this close continue each other
constexpr double kClearPeriods = 0.25;   // by which one of two intervals is nearer to a period
constexpr double kMaxJitters = 4.0;      // by which an interval may seem regular by chance
constexpr double kLostRowPeriods = 0.1;  // an interval of one period is likelier than one of two

using Stamps = std::span<const std::int64_t>;

std::vector<std::size_t> descents(Stamps stamps) {
    std::vector<std::size_t> rows;
    for (std::size_t i = 1; i < stamps.size(); ++i)
        if (stamps[i] < stamps[i - 1]) rows.push_back(i);
    return rows;
}

// Returns the median rise from row to row. Rows that mostly descend are written backwards.
std::int64_t median_rise_ns(Stamps stamps) {
    const auto num_descents = std::ssize(descents(stamps));
    std::vector<std::int64_t> sorted;
    if (num_descents * 2 > std::ssize(stamps)) {
        sorted.assign(stamps.begin(), stamps.end());
        std::sort(sorted.begin(), sorted.end());
        stamps = sorted;
    }
    std::vector<std::int64_t> rises;
    rises.reserve(stamps.size());
    for (std::size_t i = 1; i < stamps.size(); ++i)
        if (stamps[i] > stamps[i - 1]) rises.push_back(stamps[i] - stamps[i - 1]);
    return stats::upper_median(std::move(rises));
}

// Returns the median distance of rises from the period.
double median_jitter_ns(Stamps stamps, std::int64_t period_ns) {
    std::vector<double> jitters_ns;
    for (std::size_t i = 1; i < stamps.size(); ++i)
        if (const std::int64_t rise_ns = stamps[i] - stamps[i - 1]; rise_ns > 0)
            jitters_ns.push_back(std::abs(static_cast<double>(rise_ns - period_ns)));
    return stats::upper_median(std::move(jitters_ns));
}

TableClock without_steps(Stamps stamps) {
    TableClock clock;
    if (stamps.empty()) return clock;
    clock.period_ns = median_rise_ns(stamps);
    clock.first_ns = stamps.front();
    clock.last_ns = stamps.back();
    return clock;
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

// Returns whether a row follows the rows before the late ones, not the late ones: these are a few
// wrong timestamps, and no step.
bool goes_on_without(std::int64_t stamp_ns,
                     std::int64_t last_before_ns,
                     std::int64_t last_late_ns,
                     std::int64_t period_ns) {
    const auto irregularity_ns = [&](std::int64_t earlier_ns) {
        return static_cast<double>(std::abs(stamp_ns - earlier_ns - period_ns));
    };
    return irregularity_ns(last_late_ns) >
           irregularity_ns(last_before_ns) + kClearPeriods * static_cast<double>(period_ns);
}

// Returns the rows that come after a later one, up to the first that comes after all of `before`.
Stamps late_rows(Stamps before, Stamps after) {
    const auto end = std::find_if(
        after.begin(), after.end(), [&](std::int64_t t) { return t >= before.back(); });
    return {after.begin(), end};
}

// Returns whether the clock was set back between the sorted rows of `before` and the rows that
// follow, the first `num_rising` of which are in order.
bool is_step(Stamps before,
             Stamps after,
             std::size_t num_rising,
             std::size_t min_late,
             std::int64_t period_ns) {
    if (before.size() < kMinRunRows || after.size() < kMinRunRows) return false;
    const std::int64_t block_end_ns = after[num_rising - 1];
    const bool continue_each_other =
        block_end_ns < before.front() &&
        is_within(before.front() - block_end_ns, kJointPeriods, period_ns);
    if (continue_each_other) return false;
    const Stamps late = late_rows(before, after);
    if (late.size() < min_late) return false;
    if (late.size() < kMinRunRows && late.size() < after.size() &&
        goes_on_without(after[late.size()], before.back(), late.back(), period_ns))
        return false;
    const auto num_fitting = std::count_if(
        late.begin(), late.end(), [&](std::int64_t t) { return has_room(before, t, period_ns); });
    return num_fitting * 2 <= std::ssize(late);
}

// Adds rows to sorted ones. Returns the number of rows that it looked at.
std::size_t merge_into(std::vector<std::int64_t>& sorted, Stamps rising) {
    const auto first = std::lower_bound(sorted.begin(), sorted.end(), rising.front());
    const auto begin = first - sorted.begin();
    const auto middle = std::ssize(sorted);
    sorted.insert(sorted.end(), rising.begin(), rising.end());
    std::inplace_merge(sorted.begin() + begin, sorted.begin() + middle, sorted.end());
    return static_cast<std::size_t>(middle - begin) + rising.size();
}

// Returns the steps of a table whose rows are in order up to each of `ends`, each with at least
// `min_late` rows that are earlier than rows before; nullopt if the table is not sorted at all.
std::optional<TableClock> steps_between(Stamps stamps,
                                        const std::vector<std::size_t>& ends,
                                        std::size_t min_late) {
    TableClock clock = without_steps(stamps);
    std::vector<std::int64_t> run;  // the rows since the last step, sorted
    std::size_t begin = 0;
    std::size_t num_visited = 0;
    std::int64_t shift_ns = 0;
    for (const std::size_t end : ends) {
        const Stamps rest = stamps.subspan(begin);
        if (!run.empty()) num_visited += late_rows(run, rest).size();
        if (!run.empty() && is_step(run, rest, end - begin, min_late, clock.period_ns)) {
            shift_ns += run.back() + clock.period_ns - stamps[begin];
            clock.steps.push_back({begin, run.back(), stamps[begin], shift_ns});
            run.clear();
        }
        num_visited += merge_into(run, rest.first(end - begin));
        if (clock.steps.size() > kMaxSteps || shift_ns > kMaxShift_ns) return std::nullopt;
        if (num_visited > kMaxVisits * stamps.size()) return std::nullopt;
        begin = end;
    }
    return clock;
}

// The timestamps that a known clock gave before and after one of its steps.
struct KnownStep {
    std::int64_t begin_ns = 0;  // of the run before it
    ClockStep step;
    std::int64_t end_ns = 0;   // of the run after it
    std::int64_t back_ns = 0;  // by this step alone
};

KnownStep known_step(const TableClock& known, std::size_t k) {
    const std::vector<ClockStep>& steps = known.steps;
    KnownStep result;
    result.step = steps[k];
    result.begin_ns = k > 0 ? steps[k - 1].first_after_ns : known.first_ns;
    result.end_ns = k + 1 < steps.size() ? steps[k + 1].last_before_ns : known.last_ns;
    result.back_ns = steps[k].shift_ns - (k > 0 ? steps[k - 1].shift_ns : 0);
    return result;
}

// Finds the rows of one table at the steps of a known clock.
class StepFinder {
public:
    StepFinder(Stamps stamps, std::int64_t period_ns, std::int64_t known_period_ns)
        : stamps_(stamps),
          jitter_ns_(median_jitter_ns(stamps, period_ns)),
          period_ns_(static_cast<double>(std::max<std::int64_t>(1, period_ns))),
          tolerance_ns_(static_cast<std::int64_t>(
              std::min(kHolePeriods * period_ns_ + 2.0 * static_cast<double>(known_period_ns),
                       static_cast<double>(kMaxShift_ns)))) {}

    // Returns the first row after a step, at least `begin`; the number of rows if the table ends
    // before the step; nullopt if it contradicts.
    std::optional<std::size_t> first_row_after(const KnownStep& known, std::size_t begin) const {
        if (const auto row = descent_or_irregularity(known, begin)) return row;
        if (begin == stamps_.size()) return begin;
        const auto is_in = [&](std::int64_t from_ns, std::int64_t to_ns) {
            const std::int64_t stamp_ns = stamps_[begin];
            return stamp_ns >= from_ns - tolerance_ns_ && stamp_ns <= to_ns + tolerance_ns_;
        };
        const Stamps rest = stamps_.subspan(begin);
        const std::int64_t latest_ns = *std::max_element(rest.begin(), rest.end());
        const bool begins_after = begin == 0 && is_in(known.step.first_after_ns, known.end_ns) &&
                                  !is_in(known.begin_ns, known.step.last_before_ns);
        // Rows that were sorted by time begin with those after the step, but do not end with them.
        if (begins_after)
            return latest_ns <= known.end_ns + tolerance_ns_ ? std::optional(begin) : std::nullopt;
        const bool ends_before = latest_ns <= known.step.last_before_ns + tolerance_ns_;
        return ends_before ? std::optional(stamps_.size()) : std::nullopt;
    }

private:
    // Returns the row that follows the one before best once the step is taken off.
    std::optional<std::size_t> descent_or_irregularity(const KnownStep& known,
                                                       std::size_t begin) const {
        const ClockStep& step = known.step;
        std::optional<std::size_t> best;
        double best_irregularity_ns = 0.0;
        for (std::size_t i = begin + 1; i < stamps_.size(); ++i) {
            const std::int64_t before_ns = stamps_[i - 1];
            const std::int64_t after_ns = stamps_[i];
            const bool may_be = before_ns <= step.last_before_ns + tolerance_ns_ &&
                                after_ns >= step.first_after_ns - tolerance_ns_;
            const bool is_near = before_ns >= step.last_before_ns - tolerance_ns_ &&
                                 after_ns <= step.first_after_ns + tolerance_ns_;
            const std::int64_t interval_ns = after_ns - before_ns;
            if (!may_be || (interval_ns >= 0 && !is_near)) continue;
            const double irregularity = irregularity_ns(interval_ns + known.back_ns);
            // The table goes on as if there was no step.
            if (irregularity_ns(interval_ns) + kMaxJitters * jitter_ns_ < irregularity) continue;
            if (best && irregularity >= best_irregularity_ns) continue;
            best = i;
            best_irregularity_ns = irregularity;
        }
        return best;
    }

    // Returns how far an interval is from one period, or from some as rows get lost.
    double irregularity_ns(std::int64_t interval_ns) const {
        const auto interval = static_cast<double>(interval_ns);
        const double num_periods = std::max(1.0, std::round(interval / period_ns_));
        return std::abs(interval - num_periods * period_ns_) +
               kLostRowPeriods * (num_periods - 1.0) * period_ns_;
    }

    Stamps stamps_;
    double jitter_ns_;
    double period_ns_;
    std::int64_t tolerance_ns_;
};

}  // namespace

TableClock find_clock_steps(Stamps stamps) {
    std::vector<std::size_t> ends = descents(stamps);
    const std::size_t num_descents = ends.size();
    if (num_descents == 0 || num_descents > kMaxSteps + stamps.size() / kRowsOfLate)
        return without_steps(stamps);
    ends.push_back(stamps.size());
    auto clock = steps_between(stamps, ends, 1);
    // Where rows are out of order, a few late ones may have timestamps that are not exact.
    if (!clock || clock->steps.size() < num_descents)
        clock = steps_between(stamps, ends, kMinRunRows);
    return clock.value_or(without_steps(stamps));
}

TableClock find_clock_steps(Stamps stamps, const TableClock& known) {
    if (known.steps.empty()) return find_clock_steps(stamps);
    TableClock clock = without_steps(stamps);
    clock.is_known = true;
    const StepFinder finder(stamps, clock.period_ns, known.period_ns);
    std::size_t begin = 0;
    for (std::size_t k = 0; k < known.steps.size(); ++k) {
        const ClockStep& step = known.steps[k];
        const auto row = finder.first_row_after(known_step(known, k), begin);
        if (!row) return find_clock_steps(stamps);
        if (*row == stamps.size()) break;
        const std::int64_t before_ns = *row > 0 ? stamps[*row - 1] : step.last_before_ns;
        clock.steps.push_back({*row, before_ns, stamps[*row], step.shift_ns});
        begin = *row;
    }
    return clock;
}

}  // namespace divemesh::dive
