#include "worker/dive/stamp_check.hpp"

#include <algorithm>
#include <numeric>

#include "worker/base/text.hpp"
#include "worker/dive/clock_set_back.hpp"
#include "worker/dive/csv.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

// Recorders that write each row two or three times exist; more is a clock that stands still.
constexpr double kMaxRepeatedShare = 0.7;
constexpr double kGapPeriods = 5.0;
// Between two rows of a table that is sorted. A timestamp farther away is wrong, or the clock was
// set.
constexpr std::int64_t kMaxSortedGap_ns = 3'600'000'000'000;

// Returns the number of rows whose timestamp is below that of a row before them.
std::int64_t num_below_an_earlier_one(const std::vector<std::int64_t>& timestamps_ns) {
    std::int64_t last_ns = -1;
    std::int64_t num = 0;
    for (const std::int64_t timestamp_ns : timestamps_ns) {
        if (timestamp_ns < last_ns) ++num;
        last_ns = std::max(last_ns, timestamp_ns);
    }
    return num;
}

std::int64_t longest_interval_ns(const std::vector<std::int64_t>& timestamps_ns,
                                 const std::vector<std::size_t>& order) {
    std::int64_t longest_ns = 0;
    for (std::size_t i = 1; i < order.size(); ++i)
        longest_ns = std::max(longest_ns, timestamps_ns[order[i]] - timestamps_ns[order[i - 1]]);
    return longest_ns;
}

}  // namespace

std::int64_t median_period_ns(const std::vector<std::int64_t>& timestamps_ns) {
    if (timestamps_ns.size() < 2) return 0;
    std::vector<std::int64_t> periods;
    periods.reserve(timestamps_ns.size() - 1);
    for (std::size_t i = 1; i < timestamps_ns.size(); ++i)
        periods.push_back(timestamps_ns[i] - timestamps_ns[i - 1]);
    return stats::upper_median(std::move(periods));
}

std::optional<std::int64_t> StampCheck::accept(std::int64_t line, std::string_view stamp) {
    ++num_rows_;
    const auto timestamp = parse_integer(stamp);
    if (!timestamp || *timestamp < 0) {
        count(malformed_, line);
        return std::nullopt;
    }
    return timestamp;
}

void StampCheck::count(Tally& tally, std::int64_t line) {
    if (tally.count++ == 0) tally.first_line = line;
}

void StampCheck::drop_few_that_go_back(const std::vector<std::int64_t>& timestamps_ns,
                                       std::vector<std::size_t>& order) {
    std::int64_t last_ns = -1;
    std::erase_if(order, [&](std::size_t row) {
        const bool back = timestamps_ns[row] < last_ns;
        if (back) count(backwards_, lines_[row]);
        last_ns = std::max(last_ns, timestamps_ns[row]);
        return back;
    });
}

void StampCheck::drop_repeated(const std::vector<std::int64_t>& timestamps_ns,
                               std::vector<std::size_t>& order) {
    std::optional<std::int64_t> last_ns;
    std::erase_if(order, [&](std::size_t row) {
        const bool repeated = timestamps_ns[row] == last_ns;
        if (repeated) count(repeated_, lines_[row]);
        last_ns = timestamps_ns[row];
        return repeated;
    });
}

std::vector<std::size_t> StampCheck::row_order(const std::vector<std::int64_t>& timestamps_ns,
                                               SetBack set_back) {
    std::vector<std::size_t> order(timestamps_ns.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const std::int64_t num_back = num_below_an_earlier_one(timestamps_ns);
    const bool few =
        static_cast<double>(num_back) <= kMaxBadShare * static_cast<double>(timestamps_ns.size());
    if (num_back > 0 && !(set_back == SetBack::Keep && is_set_back(timestamps_ns))) {
        std::vector<std::size_t> sorted = order;
        std::stable_sort(sorted.begin(), sorted.end(), [&](std::size_t a, std::size_t b) {
            return timestamps_ns[a] < timestamps_ns[b];
        });
        const bool sortable = !is_set_back(timestamps_ns) &&
                              longest_interval_ns(timestamps_ns, sorted) <= kMaxSortedGap_ns;
        if (few || !sortable) {
            drop_few_that_go_back(timestamps_ns, order);
        } else {
            for (std::size_t row = 1; row < timestamps_ns.size(); ++row)
                if (timestamps_ns[row] < timestamps_ns[row - 1]) count(unsorted_, lines_[row]);
            order = std::move(sorted);
        }
    }
    drop_repeated(timestamps_ns, order);
    return order;
}

void StampCheck::report(const std::vector<std::int64_t>& ordered_ns, double min_period_s) {
    tell(malformed_,
         "_row_malformed",
         "malformed (a row is the timestamp in whole nanoseconds, then the values)",
         "Write the timestamp as an integer in nanoseconds and every column as a number.");
    tell(not_finite_,
         "_not_finite",
         "NaN, infinite or absurdly large",
         "Repair the recorder or remove these rows.");
    tell(repeated_,
         "_timestamp_repeated",
         "of the same timestamp as another row",
         "Remove the duplicate rows, and check the timestamps of the recorder.",
         kMaxRepeatedShare);
    tell(
        backwards_,
        "_timestamp_backwards",
        "of an earlier timestamp than a row before",
        "If the clock was set in mid-dive, cut the dive in two at this row: two folders, each with "
        "the rows of all sensors on its side of it.");
    if (unsorted_.count > 0)
        findings_.warning(sensor_ + "_timestamp_unsorted",
                          file_ + ":" + std::to_string(unsorted_.first_line),
                          "the rows are not in the order of their timestamps (first in line " +
                              std::to_string(unsorted_.first_line) + "); they were sorted",
                          "Write the table in the order of time.");
    report_period(ordered_ns, min_period_s);
}

void StampCheck::tell(const Tally& tally,
                      const std::string& code,
                      const std::string& what,
                      const std::string& remedy,
                      double max_share) {
    if (tally.count == 0) return;
    const bool too_many =
        static_cast<double>(tally.count) > max_share * static_cast<double>(num_rows_);
    const std::string message = std::to_string(tally.count) + " of " + std::to_string(num_rows_) +
                                " rows are " + what + ", the first in line " +
                                std::to_string(tally.first_line) +
                                (too_many ? "" : "; they are ignored");
    findings_.add({too_many ? Severity::Error : Severity::Warning,
                   sensor_ + code,
                   file_ + ":" + std::to_string(tally.first_line),
                   message,
                   remedy});
}

void StampCheck::report_period(const std::vector<std::int64_t>& accepted_ns, double min_period_s) {
    const std::int64_t period_ns = median_period_ns(accepted_ns);
    if (period_ns == 0) return;
    if (static_cast<double>(period_ns) * 1e-9 < min_period_s) {
        findings_.error(sensor_ + "_timestamp_unit",
                        file_,
                        "the timestamps increase by " + std::to_string(period_ns) +
                            " per row, too little for nanoseconds (milli- or microseconds?)",
                        "Write timestamps in nanoseconds.");
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
                          base::fixed(static_cast<double>(max_interval_ns) * 1e-9, 3) +
                          " s after " + std::to_string(max_after_ns) +
                          ", where there should be a row every " +
                          base::fixed(static_cast<double>(period_ns) * 1e-9, 4) + " s",
                      "Check the recorder: a full disk or a slow card loses samples.");
}

}  // namespace divemesh::dive
