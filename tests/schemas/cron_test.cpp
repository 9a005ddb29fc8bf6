#include "schemas/cron.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "schemas/error.hpp"

namespace divemesh {
namespace {

using namespace std::chrono;

std::int64_t at(int y, unsigned m, unsigned d, int hour = 0, int minute = 0) {
    const sys_days day{year(y) / month(m) / std::chrono::day(d)};
    return milliseconds(day.time_since_epoch() + hours(hour) + minutes(minute)).count();
}

struct Case {
    const char* cron;
    std::int64_t after;
    std::int64_t next;
};

// Worked out by hand from a calendar. 2026-11-24 is a Tuesday; 2028 is a leap year, 2100 is not.
const Case kCases[] = {
    {"* * * * *", at(2026, 11, 24, 12, 0), at(2026, 11, 24, 12, 1)},
    {"* * * * *", at(2026, 12, 31, 23, 59), at(2027, 1, 1)},
    {"30 4 * * *", at(2026, 11, 24, 4, 29), at(2026, 11, 24, 4, 30)},
    {"30 4 * * *", at(2026, 11, 24, 4, 30), at(2026, 11, 25, 4, 30)},
    {"0 0 31 * *", at(2026, 3, 31), at(2026, 5, 31)},
    {"0 0 30 * *", at(2026, 1, 30), at(2026, 3, 30)},
    {"59 23 28-31 2 *", at(2026, 2, 28, 23, 59), at(2027, 2, 28, 23, 59)},
    {"0 12 29 2 *", at(2026, 11, 24), at(2028, 2, 29, 12)},
    {"0 12 29 2 *", at(2096, 2, 29, 12), at(2104, 2, 29, 12)},
    {"0 6 * * mon", at(2026, 11, 24), at(2026, 11, 30, 6)},
    {"0 6 * * 7", at(2026, 11, 24), at(2026, 11, 29, 6)},
    {"0 6 * * SUN", at(2026, 11, 29, 6), at(2026, 12, 6, 6)},
    {"0 6 * * 5-7", at(2026, 11, 28, 6), at(2026, 11, 29, 6)},
    {"*/15 9-17 * * 1-5", at(2026, 11, 27, 17, 45), at(2026, 11, 30, 9)},
    {"5/20 * * * *", at(2026, 11, 24, 12, 5), at(2026, 11, 24, 12, 25)},
    {"0 0 1,15 jan,JUL *", at(2026, 7, 15), at(2027, 1, 1)},
    // Both day fields are restricted: either one matches.
    {"0 0 13 * fri", at(2026, 11, 24), at(2026, 11, 27)},
    {"0 0 13 * fri", at(2026, 12, 11), at(2026, 12, 13)},
    // One of them has a star: both must match (Monday, and an odd day).
    {"0 0 */2 * mon", at(2026, 11, 24), at(2026, 12, 7)},
    // Where clocks in Europe jump, UTC has all its hours.
    {"30 2 * * *", at(2026, 3, 29, 1), at(2026, 3, 29, 2, 30)},
    {"30 2 * * *", at(2026, 10, 25, 2, 30), at(2026, 10, 26, 2, 30)},
};

TEST(Cron, FindsTheNextTime) {
    for (const Case& c : kCases)
        EXPECT_EQ(Cron::parse(c.cron).next_after_ms(c.after), c.next) << c.cron;
}

TEST(Cron, IsNotDueInTheMinuteItIsAskedIn) {
    EXPECT_EQ(Cron::parse("* * * * *").next_after_ms(at(2026, 11, 24, 12) + 1),
              at(2026, 11, 24, 12, 1));
    EXPECT_EQ(Cron::parse("* * * * *").next_after_ms(at(2026, 11, 24, 12) - 1),
              at(2026, 11, 24, 12));
}

TEST(Cron, RefusesNonsense) {
    for (const char* text : {"",
                             "* * * *",
                             "* * * * * *",
                             "60 * * * *",
                             "* 24 * * *",
                             "* * 0 * *",
                             "* * 32 * *",
                             "* * * 13 *",
                             "* * * 0 *",
                             "* * * * 8",
                             "-1 * * * *",
                             "1- * * * *",
                             "5-1 * * * *",
                             "*/0 * * * *",
                             "*/ * * * *",
                             "1,,2 * * * *",
                             "a * * * *",
                             "* * * foo *",
                             "1.5 * * * *",
                             "* * 30 2 *",
                             "0 0 31 2,4,6,9,11 *",
                             "@daily",
                             "1/2/3 * * * *",
                             "99999999999 * * * *"})
        EXPECT_THROW(Cron::parse(text), Error) << text;
    EXPECT_THROW(Cron::parse(std::string(100'000, '*')), Error);
}

}  // namespace
}  // namespace divemesh
