#include "worker/dive/frame_list.hpp"

#include <gtest/gtest.h>

#include "tests/worker/dive/finding_matcher.hpp"

namespace divemesh::dive {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000;

std::vector<CameraRow> rows(const std::vector<std::int64_t>& times_ms) {
    std::vector<CameraRow> result;
    for (const std::int64_t time : times_ms)
        result.push_back({time * kMillisecond_ns, std::to_string(time)});
    return result;
}

constexpr std::int64_t kTolerance_ns = 5 * kMillisecond_ns;

TEST(FrameListTest, EachLeftImageGetsTheNearestRightOne) {
    const auto pairs =
        match_pairs(rows({1000, 1100, 1200, 1300}), rows({1003, 1098, 1199}), {}, kTolerance_ns);

    ASSERT_EQ(pairs.size(), 3U);
    EXPECT_EQ(pairs[0].right, "1003");
    EXPECT_EQ(pairs[1].right, "1098");
    EXPECT_EQ(pairs[2].right, "1199");
    EXPECT_EQ(pairs[2].timestamp_ns, 1200 * kMillisecond_ns);
    EXPECT_EQ(pairs[2].right_ns, 1199 * kMillisecond_ns);
}

TEST(FrameListTest, MoreThanTheToleranceApartIsNoPair) {
    EXPECT_TRUE(match_pairs(rows({1000, 1100}), rows({1006, 1106}), {}, kTolerance_ns).empty());
}

TEST(FrameListTest, ARightImageIsGivenOnceToTheNearerLeftOne) {
    const auto pairs = match_pairs(rows({1000, 1008, 1016}), rows({1007, 1016}), {}, kTolerance_ns);

    ASSERT_EQ(pairs.size(), 2U);
    EXPECT_EQ(pairs[0].left, "1008");
    EXPECT_EQ(pairs[0].right, "1007");
}

TEST(FrameListTest, ADifferenceOfTheClocksWithItsDriftIsTakenOff) {
    // The right clock is 7 s behind and loses 10 ms a second.
    const ClockDifference clocks{-7000 * kMillisecond_ns, -0.01, 10'000 * kMillisecond_ns};
    const auto pairs = match_pairs(
        rows({10'000, 11'000, 12'000}), rows({3000, 3990, 4980}), clocks, kMillisecond_ns);

    ASSERT_EQ(pairs.size(), 3U);
    EXPECT_EQ(pairs[2].right, "4980");
}

TEST(FrameListTest, ADifferenceOfTheClocksIsGuessedFromTimestamps) {
    std::vector<std::int64_t> left;
    std::vector<std::int64_t> late;
    std::vector<std::int64_t> other_epoch;
    for (int i = 0; i < 50; ++i) {
        left.push_back(1'000'000 + 100 * i);
        late.push_back(left.back() + 20);
        other_epoch.push_back(100 * i);
    }

    EXPECT_TRUE(guess_clock_difference(rows(left), rows(left)).is_zero());
    EXPECT_NEAR(
        static_cast<double>(guess_clock_difference(rows(left), rows(late)).offset_ns), 20e6, 1e3);
    EXPECT_NEAR(
        static_cast<double>(guess_clock_difference(rows(left), rows(other_epoch)).offset_ns),
        -1e12,
        1e3);
}

TEST(FrameListTest, CommentsLineEndsAndBlanksOfOtherSystemsAreRead) {
    FindingLog log;

    const auto list = parse_camera_rows(
        "\xef\xbb\xbf#timestamp,filename\r\n\r\n1000000000, a.png\r\n"
        "2000000000 ,b.png",
        "cam0",
        log);

    ASSERT_EQ(list.size(), 2U);
    EXPECT_EQ(list[0].file, "mav0/cam0/data/a.png");
    EXPECT_EQ(list[1].timestamp_ns, 2'000'000'000);
    EXPECT_TRUE(log.all().empty());
}

TEST(FrameListTest, AFileNameThatLeavesTheFolderIsOneBelowIt) {
    FindingLog log;

    const auto rows = parse_camera_rows("1000000000,../../../etc/passwd\n", "cam0", log);

    ASSERT_EQ(rows.size(), 1U);
    EXPECT_EQ(rows.front().file, "mav0/cam0/data/etc/passwd");
    for (const char* const name : {"..", "../..", "/", "C:", "a\x01.png"}) {
        FindingLog refused;
        parse_camera_rows(std::string("1000000000,") + name + "\n", "cam0", refused);
        EXPECT_THAT(refused.all(), HasFinding(Severity::Error, "cam0_row_malformed", "data.csv:1"))
            << name;
    }
}

}  // namespace
}  // namespace divemesh::dive
