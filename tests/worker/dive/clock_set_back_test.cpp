#include "worker/dive/clock_set_back.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/worker/dive/finding_matcher.hpp"
#include "worker/dive/frame_list.hpp"

namespace divemesh::dive {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

// Returns a table of rows every `period_ns` from `from_ns` on, whose clock is set back by two
// seconds before the row `step`.
std::vector<std::int64_t> set_back_by_2_s(std::int64_t from_ns,
                                          std::int64_t period_ns,
                                          std::size_t num_rows,
                                          std::size_t step) {
    std::vector<std::int64_t> stamps;
    for (std::size_t row = 0; row < num_rows; ++row)
        stamps.push_back(from_ns + static_cast<std::int64_t>(row) * period_ns -
                         (row >= step ? 2 * kSecond_ns : 0));
    return stamps;
}

std::vector<std::int64_t*> pointers(std::vector<std::int64_t>& stamps) {
    std::vector<std::int64_t*> result;
    for (std::int64_t& stamp : stamps) result.push_back(&stamp);
    return result;
}

TEST(IsSetBackTest, TellsASetClockFromRowsOutOfOrder) {
    EXPECT_TRUE(is_set_back(set_back_by_2_s(kSecond_ns, kSecond_ns / 10, 60, 40)));
    EXPECT_FALSE(is_set_back(set_back_by_2_s(kSecond_ns, kSecond_ns / 10, 60, 60)));
    EXPECT_FALSE(is_set_back({1, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 2, 20, 21, 3, 4, 5}));
    // The second half was written first.
    EXPECT_FALSE(is_set_back(
        {20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19}));
}

// The IMU at 200 Hz tells the step to 5 ms; the cameras alone would to 100 ms.
TEST(UndoSetBacksTest, AllTablesMoveByTheSameTimeAndKeepTheirOrder) {
    auto cam = set_back_by_2_s(5 * kSecond_ns, kSecond_ns / 10, 60, 40);
    auto imu = set_back_by_2_s(5 * kSecond_ns + 3'000'000, kSecond_ns / 200, 1200, 798);
    std::vector<TableStamps> tables = {{"cam0", pointers(cam)}, {"imu0", pointers(imu)}};
    FindingLog log;
    undo_set_backs(tables, log);
    EXPECT_THAT(log.all(),
                HasFinding(Severity::Warning, "clock_set_back", "2.000 s before row 40"));
    for (std::size_t row = 1; row < cam.size(); ++row)
        EXPECT_LE(std::abs(cam[row] - cam[row - 1] - kSecond_ns / 10), 5'000'000) << row;
    for (std::size_t row = 1; row < imu.size(); ++row) EXPECT_GT(imu[row], imu[row - 1]) << row;
    EXPECT_EQ(cam[59] - imu[1199],
              5 * kSecond_ns + 59 * kSecond_ns / 10 -
                  (5 * kSecond_ns + 3'000'000 + 1199 * kSecond_ns / 200));
}

TEST(UndoSetBacksTest, TablesThatDisagreeAreRefused) {
    auto cam = set_back_by_2_s(5 * kSecond_ns, kSecond_ns / 10, 60, 40);
    auto imu = set_back_by_2_s(5 * kSecond_ns, kSecond_ns / 200, 1200, 1200);
    std::vector<TableStamps> tables = {{"cam0", pointers(cam)}, {"imu0", pointers(imu)}};
    FindingLog log;
    undo_set_backs(tables, log);
    EXPECT_THAT(log.all(), HasFinding(Severity::Error, "clock_set_back", "1 times in cam0"));
}

std::string camera_table(const std::vector<int>& order) {
    std::string text;
    for (const int i : order)
        text +=
            std::to_string(kSecond_ns + i * (kSecond_ns / 10)) + "," + std::to_string(i) + ".png\n";
    return text;
}

TEST(TableOrderTest, RowsInTheOrderOfNamesAreSorted) {
    FindingLog log;
    const auto rows = parse_camera_rows(
        camera_table({0, 1, 10, 11, 12, 13, 2, 3, 4, 5, 6, 7, 8, 9}), "cam0", log);
    ASSERT_EQ(rows.size(), 14U);
    for (std::size_t i = 0; i < rows.size(); ++i)
        EXPECT_EQ(rows[i].file, "mav0/cam0/data/" + std::to_string(i) + ".png");
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "cam0_timestamp_unsorted", "line 7"));
    EXPECT_FALSE(has_error(log.all()));
}

TEST(TableOrderTest, RowsThatStandTwiceAreDropped) {
    FindingLog log;
    const auto rows =
        parse_camera_rows(camera_table({0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6}), "cam0", log);
    EXPECT_EQ(rows.size(), 7U);
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "cam0_timestamp_repeated", "7 of 14"));
    EXPECT_FALSE(has_error(log.all()));
}

TEST(TableOrderTest, AClockThatStandsStillIsRefused) {
    FindingLog log;
    parse_camera_rows(camera_table({0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1}), "cam0", log);
    EXPECT_THAT(log.all(), HasFinding(Severity::Error, "cam0_timestamp_repeated", "14 of 16"));
}

}  // namespace
}  // namespace divemesh::dive
