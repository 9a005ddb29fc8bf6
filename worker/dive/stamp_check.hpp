#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// Accepts rows with rising timestamps and reports the others: one finding per kind, with their
// number and the line of the first. A few bad rows are a warning; above one in twenty the table is
// an error.
class StampCheck {
public:
    // `sensor` is the prefix of the codes ("imu" -> "imu_gap"), `file` that of line numbers.
    StampCheck(std::string sensor, std::string file, FindingLog& findings)
        : sensor_(std::move(sensor)), file_(std::move(file)), findings_(findings) {}

    // Returns the timestamp of a row; nullopt if the row must be skipped.
    std::optional<std::int64_t> accept(std::int64_t line, std::string_view stamp);
    void count_malformed(std::int64_t line) { count(malformed_, line); }
    void count_not_finite(std::int64_t line) { count(not_finite_, line); }
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
    void tell(const Tally& tally,
              const std::string& code,
              const std::string& what,
              const std::string& remedy);
    void report_period(const std::vector<std::int64_t>& accepted_ns, double min_period_s);

    std::string sensor_;
    std::string file_;
    FindingLog& findings_;
    std::int64_t num_rows_ = 0;
    std::optional<std::int64_t> last_;
    Tally malformed_;
    Tally not_finite_;
    Tally repeated_;
    Tally backwards_;
};

// Returns the median difference of rising timestamps; 0 for fewer than two.
std::int64_t median_period_ns(const std::vector<std::int64_t>& timestamps_ns);

}  // namespace divemesh::dive
