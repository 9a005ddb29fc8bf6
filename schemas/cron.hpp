#pragma once

#include <bitset>
#include <cstdint>
#include <string_view>

namespace divemesh {

// A cron expression: five fields of crontab(5), minute hour day-of-month month day-of-week, in UTC.
// A field is *, a number, a range a-b, either with a step /n, or several of these with commas.
// Months and weekdays may be three letters; Sunday is 0 or 7. As in cron, if both day fields are
// restricted, a day is due when either of them matches.
class Cron {
public:
    // Throws Error{InvalidArgument}, which names the wrong field, also for a day that never comes
    // (30 February).
    static Cron parse(std::string_view text);

    // Returns the first due minute after `unix_ms`.
    std::int64_t next_after_ms(std::int64_t unix_ms) const;

private:
    bool is_day_due(unsigned month, unsigned day, unsigned weekday) const;

    std::bitset<60> minutes_;
    std::bitset<24> hours_;
    std::bitset<32> days_;
    std::bitset<13> months_;
    std::bitset<7> weekdays_;
    bool any_day_ = false;  // the field began with *
    bool any_weekday_ = false;
};

}  // namespace divemesh
