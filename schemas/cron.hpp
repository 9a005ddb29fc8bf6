#pragma once

#include <bitset>
#include <cstdint>
#include <string_view>

namespace divemesh {

// When something is due: five fields of crontab(5), minute hour day-of-month month day-of-week, in
// UTC. A field is *, a number, a range a-b, either with a step /n, or several of these with commas;
// months and weekdays also by three letters; Sunday is 0 or 7. As cron has it, a day is due when
// either of the two day fields fits if both are restricted.
class Cron {
public:
    // Throws Error{InvalidArgument} that says which field is wrong, also for a day that never comes
    // (30 February).
    static Cron parse(std::string_view text);

    // The first due minute after `unix_ms`.
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
