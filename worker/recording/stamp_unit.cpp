#include "worker/recording/stamp_unit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "worker/dive/csv.hpp"
#include "worker/dive/stamp_check.hpp"
#include "worker/recording/civil_time.hpp"

namespace divemesh::recording {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kFirstDate_ns =
    kSecond_ns * kSecond_ns;                               // of 2001: no unit has two readings
constexpr std::int64_t kMinUptime = 1'000'000'000;         // smaller numbers are counters
constexpr std::int64_t kMinPeriod_ns = 1'000'000;          // 1000 images a second
constexpr std::int64_t kMaxPeriod_ns = 3600 * kSecond_ns;  // more is a number of another unit

struct UnitRow {
    StampUnit unit;
    const char* symbol;
    const char* name;
    std::int64_t length_ns;
};
constexpr std::array<UnitRow, 4> kUnits = {{
    {StampUnit::Nanoseconds, "ns", "nanoseconds", 1},
    {StampUnit::Microseconds, "us", "microseconds", 1'000},
    {StampUnit::Milliseconds, "ms", "milliseconds", 1'000'000},
    {StampUnit::Seconds, "s", "seconds", kSecond_ns},
}};

const UnitRow& row_of(StampUnit unit) { return kUnits[static_cast<std::size_t>(unit)]; }

// Returns the times of all numbers in a unit; empty if one of them has none.
std::vector<std::int64_t> stamps_in(std::span<const std::string> numbers, StampUnit unit) {
    std::vector<std::int64_t> stamps;
    stamps.reserve(numbers.size());
    for (const std::string& number : numbers) {
        const auto stamp = parse_stamp(number, unit);
        if (!stamp) return {};
        stamps.push_back(*stamp);
    }
    std::sort(stamps.begin(), stamps.end());
    return stamps;
}

bool has_fraction(const std::string& number) { return number.find('.') != std::string::npos; }

// Returns the time of a number with an exponent, which KITTI writes: "1.036224e-01".
std::optional<std::int64_t> parse_with_exponent(std::string_view text, std::int64_t length_ns) {
    const auto value = dive::parse_double(text);
    const double time_ns = value.value_or(-1.0) * static_cast<double>(length_ns);
    const bool is_in_range =
        time_ns >= 0.0 && time_ns <= static_cast<double>(dive::kMaxTimestamp_ns);
    return is_in_range ? std::optional<std::int64_t>(std::llround(time_ns)) : std::nullopt;
}

}  // namespace

std::optional<StampUnit> unit_by_name(std::string_view name) {
    for (const UnitRow& row : kUnits)
        if (row.symbol == name) return row.unit;
    return std::nullopt;
}

const char* name_of(StampUnit unit) { return row_of(unit).name; }

std::optional<std::int64_t> parse_stamp(std::string_view text, StampUnit unit) {
    const std::int64_t length_ns = row_of(unit).length_ns;
    if (text.find_first_of("eE") != std::string_view::npos)
        return parse_with_exponent(text, length_ns);
    const std::size_t point = std::min(text.find('.'), text.size());
    const auto whole = dive::parse_integer(text.substr(0, point));
    if (!whole || *whole < 0 || *whole > dive::kMaxTimestamp_ns / length_ns) return std::nullopt;
    std::int64_t stamp_ns = *whole * length_ns;
    if (point + 1 < text.size()) {
        const auto fraction = parse_fraction_ns(text.substr(point + 1));  // of the unit, in 1e-9
        if (!fraction) return std::nullopt;
        stamp_ns += *fraction / (kSecond_ns / length_ns);
    }
    return stamp_ns <= dive::kMaxTimestamp_ns ? std::optional(stamp_ns) : std::nullopt;
}

std::optional<StampUnit> unit_of_stamps(std::span<const std::string> numbers) {
    if (numbers.empty()) return std::nullopt;
    const auto seconds = stamps_in(numbers, StampUnit::Seconds);
    const bool all_fractions = std::all_of(numbers.begin(), numbers.end(), has_fraction);
    if (all_fractions && !seconds.empty()) return StampUnit::Seconds;
    for (const UnitRow& row : kUnits) {
        const auto stamps = stamps_in(numbers, row.unit);
        const bool are_dates = !stamps.empty() && stamps.front() >= kFirstDate_ns;
        if (are_dates && dive::median_period_ns(stamps) <= kMaxPeriod_ns) return row.unit;
    }
    const auto plain = stamps_in(numbers, StampUnit::Nanoseconds);
    if (plain.size() < 2 || plain.front() < kMinUptime) return std::nullopt;
    for (const UnitRow& row : kUnits) {
        const auto stamps = stamps_in(numbers, row.unit);
        if (!stamps.empty() && dive::median_period_ns(stamps) >= kMinPeriod_ns) return row.unit;
    }
    return std::nullopt;
}

}  // namespace divemesh::recording
