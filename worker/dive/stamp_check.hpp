#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// What to do with a table whose clock was set back while it was recorded.
enum class SetBack {
    Keep,   // leave the rows in the order of the file; undo_set_backs() mends their timestamps
    Refuse  // an error
};

// Puts the rows of a table into the order of their timestamps, and reports bad ones: one finding
// per kind, with their number and the line of the first. A few malformed rows are a warning; above
// one in twenty the table is an error. Rows that repeat a timestamp are dropped, and rows that are
// out of order are sorted, both with a warning.
class StampCheck {
public:
    // `sensor` is the prefix of the codes ("imu" -> "imu_gap"), `file` that of line numbers.
    StampCheck(std::string sensor, std::string file, FindingLog& findings)
        : sensor_(std::move(sensor)), file_(std::move(file)), findings_(findings) {}

    // Returns the timestamp of a row; nullopt if the row must be skipped.
    std::optional<std::int64_t> accept(std::int64_t line, std::string_view stamp);
    // Notes that the row of this line is one of the table; in the order of the file.
    void keep(std::int64_t line) { lines_.push_back(line); }
    void count_malformed(std::int64_t line) { count(malformed_, line); }
    void count_not_finite(std::int64_t line) { count(not_finite_, line); }
    // Puts the kept rows into order and reports the findings; call it after the last row. A period
    // below `min_period_s` means that the timestamps are not nanoseconds.
    template <typename Row>
    void finish(std::vector<Row>& rows, double min_period_s, SetBack set_back) {
        std::vector<std::int64_t> timestamps_ns;
        for (const Row& row : rows) timestamps_ns.push_back(row.timestamp_ns);
        std::vector<Row> ordered;
        std::vector<std::int64_t> ordered_ns;
        for (const std::size_t row : row_order(timestamps_ns, set_back)) {
            ordered.push_back(std::move(rows[row]));
            ordered_ns.push_back(timestamps_ns[row]);
        }
        rows = std::move(ordered);
        report(ordered_ns, min_period_s);
    }

    const std::string& file() const { return file_; }

private:
    static constexpr double kMaxBadShare = 0.05;

    struct Tally {
        std::int64_t count = 0;
        std::int64_t first_line = 0;
    };
    static void count(Tally& tally, std::int64_t line);
    // Returns the numbers of the rows to use, in the order of their timestamps.
    std::vector<std::size_t> row_order(const std::vector<std::int64_t>& timestamps_ns,
                                       SetBack set_back);
    void drop_few_that_go_back(const std::vector<std::int64_t>& timestamps_ns,
                               std::vector<std::size_t>& order);
    void drop_repeated(const std::vector<std::int64_t>& timestamps_ns,
                       std::vector<std::size_t>& order);
    void report(const std::vector<std::int64_t>& ordered_ns, double min_period_s);
    void tell(const Tally& tally,
              const std::string& code,
              const std::string& what,
              const std::string& remedy,
              double max_share = kMaxBadShare);
    void report_period(const std::vector<std::int64_t>& accepted_ns, double min_period_s);

    std::string sensor_;
    std::string file_;
    FindingLog& findings_;
    std::int64_t num_rows_ = 0;
    std::vector<std::int64_t> lines_;  // of the kept rows
    Tally malformed_;
    Tally not_finite_;
    Tally repeated_;
    Tally backwards_;
    Tally unsorted_;
};

// Returns the median difference of rising timestamps; 0 for fewer than two.
std::int64_t median_period_ns(const std::vector<std::int64_t>& timestamps_ns);

}  // namespace divemesh::dive
