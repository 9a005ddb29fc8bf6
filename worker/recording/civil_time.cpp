#include "worker/recording/civil_time.hpp"

#include <algorithm>
#include <chrono>

#include "worker/dive/csv.hpp"
#include "worker/dive/stamp_check.hpp"

namespace divemesh::recording {
namespace {

namespace chrono = std::chrono;

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::size_t kWhole_chars = 19;  // "2011-09-26 13:02:25"
constexpr std::size_t kMaxDigits = 9;     // of a second; further ones are below a nanosecond

bool are_digits(std::string_view text) {
    return !text.empty() &&
           std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// Returns whether a text has digits where a date and time has them, and its separators between.
bool has_form(std::string_view text) {
    constexpr std::string_view kForm = "dddd-dd-ddtdd:dd:dd";
    for (std::size_t i = 0; i < kForm.size(); ++i) {
        const char c = text[i];
        const bool fits = kForm[i] == 'd'   ? c >= '0' && c <= '9'
                          : kForm[i] == '-' ? c == '-' || c == ':' || c == '/'
                          : kForm[i] == 't' ? c == ' ' || c == 'T'
                                            : c == ':';
        if (!fits) return false;
    }
    return true;
}

int number_at(std::string_view text, std::size_t offset, std::size_t num_digits) {
    return static_cast<int>(dive::parse_integer(text.substr(offset, num_digits)).value_or(-1));
}

std::optional<std::int64_t> whole_seconds(std::string_view text) {
    const chrono::year_month_day date{chrono::year(number_at(text, 0, 4)),
                                      chrono::month(static_cast<unsigned>(number_at(text, 5, 2))),
                                      chrono::day(static_cast<unsigned>(number_at(text, 8, 2)))};
    const int hour = number_at(text, 11, 2);
    const int minute = number_at(text, 14, 2);
    const int second = number_at(text, 17, 2);
    if (!date.ok() || hour > 23 || minute > 59 || second > 60) return std::nullopt;
    const std::int64_t days = chrono::sys_days(date).time_since_epoch().count();
    const std::int64_t total_s = ((days * 24 + hour) * 60 + minute) * 60 + second;
    const bool is_in_range = total_s >= 0 && total_s < dive::kMaxTimestamp_ns / kSecond_ns;
    return is_in_range ? std::optional(total_s) : std::nullopt;
}

}  // namespace

std::optional<std::int64_t> parse_fraction_ns(std::string_view digits) {
    if (!are_digits(digits)) return std::nullopt;
    std::int64_t fraction_ns = 0;
    for (std::size_t i = 0; i < kMaxDigits; ++i)
        fraction_ns = 10 * fraction_ns + (i < digits.size() ? digits[i] - '0' : 0);
    return fraction_ns;
}

std::optional<std::int64_t> parse_zone_ns(std::string_view text) {
    if (text == "Z") return 0;
    const bool has_sign = text.size() == 6 && (text[0] == '+' || text[0] == '-') && text[3] == ':';
    if (!has_sign || !are_digits(text.substr(1, 2)) || !are_digits(text.substr(4, 2)))
        return std::nullopt;
    const std::int64_t minutes = 60 * number_at(text, 1, 2) + number_at(text, 4, 2);
    return (text[0] == '-' ? -minutes : minutes) * 60 * kSecond_ns;
}

std::optional<std::int64_t> parse_civil_time(std::string_view text) {
    if (text.ends_with('Z')) text.remove_suffix(1);
    if (text.size() < kWhole_chars || !has_form(text)) return std::nullopt;
    const auto seconds = whole_seconds(text);
    const std::string_view rest = text.substr(kWhole_chars);
    if (!seconds) return std::nullopt;
    if (rest.empty()) return *seconds * kSecond_ns;
    const auto fraction_ns = rest.front() == '.' ? parse_fraction_ns(rest.substr(1)) : std::nullopt;
    if (!fraction_ns) return std::nullopt;
    return *seconds * kSecond_ns + *fraction_ns;
}

}  // namespace divemesh::recording
