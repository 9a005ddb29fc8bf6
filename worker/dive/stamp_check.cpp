#include "worker/dive/stamp_check.hpp"

#include "worker/base/text.hpp"
#include "worker/dive/csv.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr double kMaxBadShare = 0.05;
constexpr double kGapPeriods = 5.0;

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
    if (last_ && *timestamp == *last_) {
        count(repeated_, line);
        return std::nullopt;
    }
    if (last_ && *timestamp < *last_) {
        count(backwards_, line);
        return std::nullopt;
    }
    last_ = timestamp;
    return timestamp;
}

void StampCheck::count(Tally& tally, std::int64_t line) {
    if (tally.count++ == 0) tally.first_line = line;
}

void StampCheck::report(const std::vector<std::int64_t>& accepted_ns, double min_period_s) {
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
         "of the same timestamp as the row before",
         "Remove the duplicate rows, and check the timestamps of the recorder.");
    tell(backwards_,
         "_timestamp_backwards",
         "of an earlier timestamp than a row before",
         "Record with a clock that only runs forward; do not set the time during a dive.");
    report_period(accepted_ns, min_period_s);
}

void StampCheck::tell(const Tally& tally,
                      const std::string& code,
                      const std::string& what,
                      const std::string& remedy) {
    if (tally.count == 0) return;
    const bool too_many =
        static_cast<double>(tally.count) > kMaxBadShare * static_cast<double>(num_rows_);
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
