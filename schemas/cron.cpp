#include "schemas/cron.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh {
namespace {

constexpr std::int64_t kMinute_ms = 60'000;
constexpr int kDaysToLookAt = 366 * 41;  // a Monday, 29 February: 28 years, 40 around 2100

using Names = std::vector<std::string_view>;
const Names kNoNames;
const Names kMonthNames = {
    "", "jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"};
const Names kDayNames = {"sun", "mon", "tue", "wed", "thu", "fri", "sat"};

struct Field {
    std::string_view what;
    unsigned min;
    unsigned max;
    const Names& names;
};

[[noreturn]] void refuse(const Field& field, std::string_view text) {
    throw Error(
        ErrorCode::InvalidArgument,
        "cron: the " + std::string(field.what) + " '" + std::string(text.substr(0, 60)) +
            "' must be *, a number from " + std::to_string(field.min) + " to " +
            std::to_string(field.max) +
            ", a range a-b, optionally with /step, or several of these separated by commas");
}

std::optional<unsigned> number_of(std::string_view text) {
    unsigned value = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || code != std::errc() || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

unsigned value_of(const Field& field, std::string_view text, std::string_view whole) {
    std::string lower(text);
    std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    const auto named = std::find(field.names.begin(), field.names.end(), lower);
    if (!lower.empty() && named != field.names.end())
        return static_cast<unsigned>(named - field.names.begin());
    const auto number = number_of(text);
    if (!number || *number < field.min || *number > field.max) refuse(field, whole);
    return *number;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (std::size_t start = 0; start <= text.size();) {
        const auto end = std::min(text.find(separator, start), text.size());
        parts.push_back(text.substr(start, end - start));
        start = end + 1;
    }
    return parts;
}

// Adds "*", "5", "1-5", "*/10" or "1-30/2"; a number with a step runs to the end, as in cron.
template <std::size_t kSize>
void add_range(const Field& field, std::string_view text, std::bitset<kSize>& set) {
    const auto slash = split(text, '/');
    if (slash.size() > 2) refuse(field, text);
    const auto step = slash.size() == 2 ? number_of(slash[1]) : std::optional(1U);
    if (!step || *step == 0 || *step > field.max) refuse(field, text);
    unsigned first = field.min;
    unsigned last = field.max;
    if (slash[0] != "*") {
        const auto ends = split(slash[0], '-');
        if (ends.size() > 2) refuse(field, text);
        first = value_of(field, ends[0], text);
        if (ends.size() == 2) last = value_of(field, ends[1], text);
        if (ends.size() == 1 && slash.size() == 1) last = first;
        if (first > last) refuse(field, text);
    }
    for (unsigned value = first; value <= last; value += *step) set.set(value % kSize);
}

template <std::size_t kSize>
void parse_field(const Field& field, std::string_view text, std::bitset<kSize>& set) {
    for (const std::string_view part : split(text, ',')) add_range(field, part, set);
}

std::vector<std::string_view> words_of(std::string_view text) {
    std::vector<std::string_view> words;
    std::size_t start = text.find_first_not_of(" \t");
    while (start != std::string_view::npos) {
        const auto end = std::min(text.find_first_of(" \t", start), text.size());
        words.push_back(text.substr(start, end - start));
        start = text.find_first_not_of(" \t", end);
    }
    return words;
}

}  // namespace

Cron Cron::parse(std::string_view text) {
    const auto words = words_of(text);
    if (text.size() > 500 || words.size() != 5)
        throw Error(ErrorCode::InvalidArgument,
                    "cron: give five fields: minute hour day-of-month month day-of-week, as in '30 "
                    "4 * * mon'");
    Cron cron;
    parse_field({"minute", 0, 59, kNoNames}, words[0], cron.minutes_);
    parse_field({"hour", 0, 23, kNoNames}, words[1], cron.hours_);
    parse_field({"day of the month", 1, 31, kNoNames}, words[2], cron.days_);
    parse_field({"month", 1, 12, kMonthNames}, words[3], cron.months_);
    parse_field({"day of the week", 0, 7, kDayNames}, words[4], cron.weekdays_);
    cron.any_day_ = words[2].starts_with('*');
    cron.any_weekday_ = words[4].starts_with('*');
    cron.next_after_ms(0);
    return cron;
}

bool Cron::is_day_due(unsigned month, unsigned day, unsigned weekday) const {
    if (!months_[month]) return false;
    if (any_day_ || any_weekday_) return days_[day] && weekdays_[weekday];
    return days_[day] || weekdays_[weekday];
}

std::int64_t Cron::next_after_ms(std::int64_t unix_ms) const {
    namespace chrono = std::chrono;
    const chrono::sys_time<chrono::milliseconds> start{
        chrono::milliseconds((unix_ms / kMinute_ms + 1) * kMinute_ms)};
    auto day = chrono::floor<chrono::days>(start);
    auto minute_of_day = static_cast<unsigned>(chrono::floor<chrono::minutes>(start - day).count());
    for (int i = 0; i < kDaysToLookAt; ++i, day += chrono::days(1), minute_of_day = 0) {
        const chrono::year_month_day date{day};
        if (!is_day_due(static_cast<unsigned>(date.month()),
                        static_cast<unsigned>(date.day()),
                        chrono::weekday(day).c_encoding()))
            continue;
        for (unsigned minute = minute_of_day; minute < 24 * 60; ++minute)
            if (hours_[minute / 60] && minutes_[minute % 60])
                return chrono::milliseconds(day.time_since_epoch()).count() +
                       static_cast<std::int64_t>(minute) * kMinute_ms;
    }
    throw Error(ErrorCode::InvalidArgument, "cron: this day does not exist in any month");
}

}  // namespace divemesh
