#include "worker/dive/clock_steps.hpp"

#include <gtest/gtest.h>

#include "tests/worker/dive/finding_matcher.hpp"
#include "worker/dive/common_clock.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/dive/sensor_tables.hpp"

namespace divemesh::dive {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000;
constexpr const char* kFile = "mav0/imu0/data.csv";

// A table of 100 rows at 10 Hz whose clock is set back by `back_ms` before row `at`.
std::vector<std::int64_t> stamps_set_back(int at, int back_ms) {
    std::vector<std::int64_t> stamps_ns;
    for (int i = 0; i < 100; ++i)
        stamps_ns.push_back((100'000 + 100 * i - (i < at ? 0 : back_ms)) * kMillisecond_ns);
    return stamps_ns;
}

std::string camera_csv(const std::vector<std::int64_t>& stamps_ns) {
    std::string text;
    for (std::size_t i = 0; i < stamps_ns.size(); ++i)
        text += std::to_string(stamps_ns[i]) + "," + std::to_string(i) + ".png\n";
    return text;
}

std::string imu_row(std::int64_t stamp_ns, const std::string& values) {
    return std::to_string(stamp_ns) + "," + values + "\n";
}

TEST(ClockStepsTest, AClockThatWasSetBackIsFoundWithItsShift) {
    for (const int back_ms : {300, 2000, 2050, 99'000}) {
        const TableClock clock = find_clock_steps(stamps_set_back(60, back_ms));
        ASSERT_EQ(clock.steps.size(), 1U) << back_ms;
        EXPECT_EQ(clock.steps[0].first_row, 60U);
        EXPECT_EQ(clock.steps[0].shift_ns, back_ms * kMillisecond_ns);
    }
}

TEST(ClockStepsTest, AClockThatWasSetBackTwiceAddsItsShifts) {
    std::vector<std::int64_t> stamps = stamps_set_back(30, 1000);
    for (std::size_t i = 70; i < stamps.size(); ++i) stamps[i] -= 500 * kMillisecond_ns;

    const TableClock clock = find_clock_steps(stamps);

    ASSERT_EQ(clock.steps.size(), 2U);
    EXPECT_EQ(clock.steps[1].shift_ns, 1500 * kMillisecond_ns);
}

TEST(ClockStepsTest, RowsOutOfOrderAreNoStep) {
    std::vector<std::int64_t> one_late = stamps_set_back(100, 0);
    std::swap(one_late[40], one_late[44]);
    EXPECT_TRUE(find_clock_steps(one_late).steps.empty());

    std::vector<std::int64_t> blocks = stamps_set_back(100, 0);
    std::rotate(blocks.begin(), blocks.begin() + 50, blocks.end());
    EXPECT_TRUE(find_clock_steps(blocks).steps.empty());
}

TEST(ClockStepsTest, RowsOfACameraAfterTheStepKeepTheirOrderAndTheirFiles) {
    FindingLog log;
    TableClock clock;

    const auto rows = parse_camera_rows(camera_csv(stamps_set_back(60, 2000)), "cam0", log, &clock);

    ASSERT_EQ(rows.size(), 100U);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        EXPECT_EQ(rows[i].file, "mav0/cam0/data/" + std::to_string(i) + ".png");
        EXPECT_EQ(rows[i].timestamp_ns, stamps_set_back(100, 0)[i]);
    }
    EXPECT_EQ(clock.steps.size(), 1U);
    EXPECT_TRUE(log.all().empty());
}

TEST(ClockStepsTest, AShuffledListIsSortedWithAWarning) {
    FindingLog log;
    std::string text;
    for (int i = 0; i < 20; ++i) {
        const int shuffled = i * 7 % 20;
        text += imu_row((1000 + shuffled) * kMillisecond_ns, "0,0,0,0,0,9.8");
    }

    const auto samples = parse_imu(text, kFile, log);

    ASSERT_EQ(samples.size(), 20U);
    for (std::size_t i = 1; i < samples.size(); ++i)
        EXPECT_EQ(samples[i].timestamp_ns - samples[i - 1].timestamp_ns, kMillisecond_ns);
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "imu_timestamp_backwards", "sorted"));
    EXPECT_FALSE(has_error(log.all()));
}

TEST(ClockStepsTest, DoubledRowsAreUsedOnceAndContradictingRowsAreRefused) {
    FindingLog log;
    std::string doubled;
    std::string contradicting;
    for (int i = 0; i < 20; ++i) {
        const std::int64_t stamp_ns = (1000 + 5 * i) * kMillisecond_ns;
        doubled += imu_row(stamp_ns, "0,0,0,0,0,9.8") + imu_row(stamp_ns, "0,0,0,0,0,9.8");
        contradicting += imu_row(stamp_ns, "0,0,0,0,0,9.8") + imu_row(stamp_ns, "0,0,1,0,0,9.8");
    }

    EXPECT_EQ(parse_imu(doubled, kFile, log).size(), 20U);
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "imu_timestamp_repeated", "20 of 40"));
    EXPECT_FALSE(has_error(log.all()));
    parse_imu(contradicting, kFile, log);
    EXPECT_THAT(log.all(), HasFinding(Severity::Error, "imu_timestamp_repeated", "other values"));
}

TEST(ClockStepsTest, TablesOfOneClockAreMovedByTheShiftOfTheFinest) {
    FindingLog log;
    const TableClock camera{100, {{60, 5900, 3900, 2100}}};
    const TableClock imu{5, {{1200, 5995, 3996, 2004}}};
    std::int64_t moved_from = 0;
    std::int64_t moved_by = 0;

    join_clocks({{"cam0",
                  camera,
                  [&](std::int64_t from, std::int64_t by) {
                      moved_from = from;
                      moved_by = by;
                  }},
                 {"imu0", imu, [](std::int64_t, std::int64_t) { FAIL(); }}},
                log);

    EXPECT_EQ(moved_from, 6000);
    EXPECT_EQ(moved_by, -96);
    ASSERT_EQ(log.all().size(), 1U);
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "clock_set_back", "imu0"));
}

TEST(ClockStepsTest, ReportsWhetherTheImuRecordedDuringAPause) {
    const std::vector<std::int64_t> frames_ns = {0, 1'000'000'000, 61'000'000'000};
    std::vector<types::ImuSample> imu;
    for (std::int64_t t = 0; t <= 61; ++t)
        for (int k = 0; k < 20; ++k) {
            imu.emplace_back();
            imu.back().timestamp_ns = t * 1'000'000'000 + k * 50'000'000;
        }
    FindingLog with_imu;
    FindingLog without;

    report_pauses(frames_ns, imu, with_imu);
    report_pauses(frames_ns, {}, without);

    EXPECT_THAT(with_imu.all(), HasFinding(Severity::Warning, "recording_paused", "IMU went on"));
    EXPECT_THAT(without.all(), HasFinding(Severity::Warning, "recording_paused", "set forward"));
}

}  // namespace
}  // namespace divemesh::dive
