#include "worker/dive/stamp_check.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/csv.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr double kMaxBadShare = 0.05;
constexpr double kGapPeriods = 5.0;
constexpr double kFarPeriods = 1000.0;

}  // namespace

std::int64_t median_period_ns(const std::vector<std::int64_t>& timestamps_ns) {
    if (timestamps_ns.size() < 2) return 0;
    std::vector<std::int64_t> periods;
    periods.reserve(timestamps_ns.size() - 1);
    for (std::size_t i = 1; i < timestamps_ns.size(); ++i)
        periods.push_back(timestamps_ns[i] - timestamps_ns[i - 1]);
    return stats::upper_median(std::move(periods));
}

std::vector<std::size_t> order_of_time(const std::vector<std::int64_t>& timestamps_ns) {
    std::vector<std::size_t> order(timestamps_ns.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return timestamps_ns[a] < timestamps_ns[b];
    });
    return order;
}

std::vector<bool> out_of_order(const std::vector<std::int64_t>& timestamps_ns) {
    std::vector<bool> is_late(timestamps_ns.size(), false);
    std::int64_t latest_ns = std::numeric_limits<std::int64_t>::min();
    for (std::size_t i = 0; i < timestamps_ns.size(); ++i) {
        is_late[i] = timestamps_ns[i] < latest_ns;
        latest_ns = std::max(latest_ns, timestamps_ns[i]);
    }
    return is_late;
}

std::vector<bool> far_from_all(const std::vector<std::int64_t>& sorted_ns, std::int64_t period_ns) {
    std::vector<bool> is_far(sorted_ns.size(), false);
    const auto is_wide = [&](std::size_t left) {
        return static_cast<double>(sorted_ns[left + 1] - sorted_ns[left]) >
               kFarPeriods * static_cast<double>(period_ns);
    };
    for (std::size_t i = 0; i < sorted_ns.size(); ++i)
        is_far[i] = (i == 0 || is_wide(i - 1)) && (i + 1 == sorted_ns.size() || is_wide(i));
    return is_far;
}

std::optional<std::int64_t> StampCheck::accept(std::int64_t line, std::string_view stamp) {
    ++num_rows_;
    const auto timestamp = parse_integer(stamp);
    if (timestamp && *timestamp >= 0 && *timestamp <= kMaxTimestamp_ns) return timestamp;
    count(malformed_, line);
    return std::nullopt;
}

void StampCheck::count(Tally& tally, std::int64_t line) {
    if (tally.count++ == 0 || line < tally.first_line) tally.first_line = line;
}

void StampCheck::report(const std::vector<std::int64_t>& accepted_ns, double min_period_s) {
    tell(malformed_,
         "_row_malformed",
         "are malformed (a row is the timestamp in whole nanoseconds, then the values)",
         "Write the timestamp as an integer in nanoseconds and every column as a number.");
    tell(not_finite_,
         "_not_finite",
         "are NaN, infinite or absurdly large",
         "Check the recorder, or remove these rows.");
    tell(repeated_,
         "_timestamp_repeated",
         "have the same timestamp as another row, with other values",
         "Write each row with its own timestamp, and check the clock of the recorder.");
    tell(misplaced_,
         "_timestamp_backwards",
         "have a timestamp far from those of the neighbouring rows",
         "Check the timestamps of the recorder.");
    tell_sorted(doubled_,
                "_timestamp_repeated",
                "are duplicates of another row",
                "each is used once",
                "Remove the duplicate rows unless they are intended.");
    tell_sorted(unsorted_,
                "_timestamp_backwards",
                "are out of order",
                "they were sorted",
                "Write the rows in the order of time.");
    report_period(accepted_ns, min_period_s);
}

void StampCheck::tell(const Tally& tally,
                      const std::string& code,
                      const std::string& what,
                      const std::string& remedy) {
    if (tally.count == 0) return;
    const bool too_many =
        static_cast<double>(tally.count) > kMaxBadShare * static_cast<double>(num_rows_);
    findings_.add({too_many ? Severity::Error : Severity::Warning,
                   sensor_ + code,
                   file_ + ":" + std::to_string(tally.first_line),
                   rows_text(tally, what) + (too_many ? advice_text() : "; they are ignored"),
                   too_many && !advice_.seen.empty() ? advice_.remedy : remedy});
}

void StampCheck::tell_sorted(const Tally& tally,
                             const std::string& code,
                             const std::string& what,
                             const std::string& consequence,
                             const std::string& remedy) {
    if (tally.count == 0) return;
    findings_.warning(sensor_ + code,
                      file_ + ":" + std::to_string(tally.first_line),
                      rows_text(tally, what) + "; " + consequence,
                      remedy);
}

std::string StampCheck::rows_text(const Tally& tally, const std::string& what) const {
    return std::to_string(tally.count) + " of " + std::to_string(num_rows_) + " rows " + what +
           ", the first in line " + std::to_string(tally.first_line);
}

std::string StampCheck::advice_text() const {
    return advice_.seen.empty() ? "" : ": " + advice_.seen;
}

void StampCheck::report_period(const std::vector<std::int64_t>& accepted_ns, double min_period_s) {
    const std::int64_t period_ns = median_period_ns(accepted_ns);
    if (period_ns == 0) return;
    if (base::to_s(period_ns) < min_period_s) {
        findings_.error(sensor_ + "_timestamp_unit",
                        file_,
                        "the timestamps increase by " + std::to_string(period_ns) +
                            " per row, too little for nanoseconds" +
                            (advice_.seen.empty() ? " (milli- or microseconds?)" : advice_text()),
                        advice_.seen.empty() ? "Write timestamps in nanoseconds." : advice_.remedy);
        return;
    }
    std::int64_t num_gaps = 0;
    std::int64_t max_interval_ns = 0;
    std::int64_t max_after_ns = 0;
    for (std::size_t i = 1; i < accepted_ns.size(); ++i) {
        const std::int64_t interval_ns = accepted_ns[i] - accepted_ns[i - 1];
        if (static_cast<double>(interval_ns) <= kGapPeriods * static_cast<double>(period_ns))
            continue;
        ++num_gaps;
        if (interval_ns <= max_interval_ns) continue;
        max_interval_ns = interval_ns;
        max_after_ns = accepted_ns[i - 1];
    }
    if (num_gaps == 0) return;
    findings_.warning(sensor_ + "_gap",
                      file_,
                      std::to_string(num_gaps) + " gaps; the longest is " +
                          base::fixed(base::to_s(max_interval_ns), 3) + " s after " +
                          std::to_string(max_after_ns) + ", where there should be a row every " +
                          base::fixed(base::to_s(period_ns), 4) + " s",
                      "Check the recorder: a full disk or a slow card loses samples.");
}

}  // namespace divemesh::dive
