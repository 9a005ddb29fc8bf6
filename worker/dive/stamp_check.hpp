#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "worker/dive/clock_steps.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/dive/table_advice.hpp"

namespace divemesh::dive {

constexpr std::int64_t kMaxTimestamp_ns = 4'000'000'000'000'000'000;  // in 2096; sums stay in range

// Checks the rows of a table, brings them into the order of their timestamps and reports what was
// wrong: one finding per kind, with the number of rows and the line of the first. Above one bad row
// in twenty the table is an error; rows that only had to be sorted, or were doubled, never are.
class StampCheck {
public:
    // `sensor` is the prefix of the codes ("imu" -> "imu_gap"), `file` that of line numbers.
    StampCheck(std::string sensor, std::string file, FindingLog& findings)
        : sensor_(std::move(sensor)), file_(std::move(file)), findings_(findings) {}

    // Returns the timestamp of a row; nullopt if it has none.
    std::optional<std::int64_t> accept(std::int64_t line, std::string_view stamp);
    void count_malformed(std::int64_t line) { count(malformed_, line); }
    void count_not_finite(std::int64_t line) { count(not_finite_, line); }

    // Sorts rows that are given in the order of the file, each with its line. Rows after the clock
    // was set back are moved behind those before, with the steps of the `known` clock where the
    // table shows them. Of rows with one timestamp the first is kept; `is_same` returns true if two
    // of them hold the same values.
    template <typename Row, typename IsSame>
    TableClock sort(std::vector<Row>& rows,
                    std::vector<std::int64_t> lines,
                    const IsSame& is_same,
                    const TableClock& known = {});

    // Notes what seems wrong with the format, for the findings that refuse the table.
    void advise(TableAdvice advice) { advice_ = std::move(advice); }
    // Reports the findings; call it after the last row. A period below `min_period_s` means that
    // the timestamps are not nanoseconds.
    void report(const std::vector<std::int64_t>& accepted_ns, double min_period_s);

    const std::string& file() const { return file_; }

private:
    struct Tally {
        std::int64_t count = 0;
        std::int64_t first_line = 0;
    };
    static void count(Tally& tally, std::int64_t line);
    template <typename Row, typename IsSame>
    void drop_doubles(std::vector<Row>& rows,
                      std::vector<std::int64_t>& lines,
                      const IsSame& is_same);
    template <typename Row>
    void put_in_order(std::vector<Row>& rows,
                      const std::vector<std::int64_t>& lines,
                      std::int64_t period_ns);
    void tell(const Tally& tally,
              const std::string& code,
              const std::string& what,
              const std::string& remedy);
    void tell_sorted(const Tally& tally,
                     const std::string& code,
                     const std::string& what,
                     const std::string& consequence,
                     const std::string& remedy);
    std::string rows_text(const Tally& tally, const std::string& what) const;
    std::string advice_text() const;
    void report_period(const std::vector<std::int64_t>& accepted_ns, double min_period_s);

    std::string sensor_;
    std::string file_;
    FindingLog& findings_;
    TableAdvice advice_;
    std::int64_t num_rows_ = 0;
    Tally malformed_;
    Tally not_finite_;
    Tally doubled_;   // same timestamp, same values
    Tally repeated_;  // same timestamp, other values
    Tally unsorted_;
    Tally misplaced_;  // far from every other row, and not where the file has it
};

// Returns the median difference of rising timestamps; 0 for fewer than two.
std::int64_t median_period_ns(const std::vector<std::int64_t>& timestamps_ns);

// Returns for each timestamp in the order of a file its place in the order of time: `order[i]` is
// the row of the file that comes i-th. Rows of one timestamp keep their order.
std::vector<std::size_t> order_of_time(const std::vector<std::int64_t>& timestamps_ns);

// Returns which rows of a file come after a row of a later timestamp.
std::vector<bool> out_of_order(const std::vector<std::int64_t>& timestamps_ns);

// Returns which rows, given in the order of time, lie more than a thousand periods from both of
// their neighbours: a wrong timestamp, not a row out of place.
std::vector<bool> far_from_all(const std::vector<std::int64_t>& sorted_ns, std::int64_t period_ns);

template <typename Row>
std::vector<std::int64_t> timestamps_of(const std::vector<Row>& rows) {
    std::vector<std::int64_t> timestamps_ns;
    timestamps_ns.reserve(rows.size());
    for (const Row& row : rows) timestamps_ns.push_back(row.timestamp_ns);
    return timestamps_ns;
}

// Moves the rows after each step of their clock behind those before; rows are in the order of the
// file.
template <typename Row>
void take_off_steps(std::vector<Row>& rows, const TableClock& clock) {
    for (std::size_t k = 0; k < clock.steps.size(); ++k) {
        const bool is_last = k + 1 == clock.steps.size();
        const std::size_t end = is_last ? rows.size() : clock.steps[k + 1].first_row;
        for (std::size_t i = clock.steps[k].first_row; i < end; ++i)
            rows[i].timestamp_ns += clock.steps[k].shift_ns;
    }
}

template <typename Row, typename IsSame>
TableClock StampCheck::sort(std::vector<Row>& rows,
                            std::vector<std::int64_t> lines,
                            const IsSame& is_same,
                            const TableClock& known) {
    drop_doubles(rows, lines, is_same);
    TableClock clock = find_clock_steps(timestamps_of(rows), known);
    take_off_steps(rows, clock);
    put_in_order(rows, lines, clock.period_ns);
    return clock;
}

// Drops rows with the timestamp and the values of an earlier row; the others keep their order.
template <typename Row, typename IsSame>
void StampCheck::drop_doubles(std::vector<Row>& rows,
                              std::vector<std::int64_t>& lines,
                              const IsSame& is_same) {
    const std::vector<std::size_t> order = order_of_time(timestamps_of(rows));
    std::vector<bool> is_double(rows.size(), false);
    std::size_t first = 0;  // of the rows with one timestamp, in `order`
    for (std::size_t i = 1; i < order.size(); ++i) {
        if (rows[order[i]].timestamp_ns != rows[order[first]].timestamp_ns) first = i;
        is_double[order[i]] = first != i && is_same(rows[order[first]], rows[order[i]]);
    }
    std::size_t num_kept = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (is_double[i]) {
            count(doubled_, lines[i]);
            continue;
        }
        if (num_kept != i) rows[num_kept] = std::move(rows[i]);
        lines[num_kept++] = lines[i];
    }
    rows.erase(rows.begin() + static_cast<std::ptrdiff_t>(num_kept), rows.end());
}

// Sorts rows by time and drops those with implausible timestamps.
template <typename Row>
void StampCheck::put_in_order(std::vector<Row>& rows,
                              const std::vector<std::int64_t>& lines,
                              std::int64_t period_ns) {
    const std::vector<std::int64_t> stamps = timestamps_of(rows);
    const std::vector<bool> is_late = out_of_order(stamps);
    const std::vector<std::size_t> order = order_of_time(stamps);
    std::vector<std::int64_t> sorted_ns;
    sorted_ns.reserve(order.size());
    for (const std::size_t row : order) sorted_ns.push_back(stamps[row]);
    const std::vector<bool> is_far = far_from_all(sorted_ns, period_ns);
    std::vector<Row> sorted;
    sorted.reserve(rows.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const std::size_t row = order[i];
        const bool is_repeated = !sorted.empty() && sorted.back().timestamp_ns == stamps[row];
        const bool is_misplaced = is_late[row] && is_far[i];
        if (is_repeated)
            count(repeated_, lines[row]);
        else if (is_misplaced)
            count(misplaced_, lines[row]);
        else if (is_late[row])
            count(unsorted_, lines[row]);
        if (!is_repeated && !is_misplaced) sorted.push_back(std::move(rows[row]));
    }
    rows = std::move(sorted);
}

}  // namespace divemesh::dive
