#include "worker/dive/clock_steps.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "tests/worker/dive/finding_matcher.hpp"
#include "worker/dive/common_clock.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/dive/sensor_tables.hpp"
#include "worker/dive/stamp_check.hpp"

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

// When rows were recorded: every `period_ms` in a part of a dive.
std::vector<std::int64_t> times(int period_ms, int begin_ms, int end_ms) {
    std::vector<std::int64_t> times_ns;
    for (int t = begin_ms; t < end_ms; t += period_ms)
        times_ns.push_back((1'000'000 + std::int64_t{t}) * kMillisecond_ns);
    return times_ns;
}

// A clock that is set back by `back_ms` when the dive is `at_ms` old.
struct SetBack {
    int at_ms = 0;
    int back_ms = 0;

    std::vector<std::int64_t> written(std::vector<std::int64_t> times_ns) const {
        for (std::int64_t& t : times_ns)
            if (t >= (1'000'000 + std::int64_t{at_ms}) * kMillisecond_ns)
                t -= back_ms * kMillisecond_ns;
        return times_ns;
    }
    // As the table of an IMU of 200 Hz shows it.
    TableClock by_imu() const { return find_clock_steps(written(times(5, 0, 100'000))); }
};

// Returns timestamps as they are once the steps of a clock are taken off.
std::vector<std::int64_t> moved(const std::vector<std::int64_t>& stamps_ns,
                                const TableClock& clock) {
    std::vector<CameraRow> rows;
    for (const std::int64_t stamp_ns : stamps_ns) rows.push_back({stamp_ns, ""});
    take_off_steps(rows, clock);
    return timestamps_of(rows);
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

TEST(ClockStepsTest, SwappedRowsDoNotHideAStep) {
    std::vector<std::int64_t> stamps = stamps_set_back(60, 2000);
    std::swap(stamps[20], stamps[21]);
    std::swap(stamps[80], stamps[81]);

    const TableClock clock = find_clock_steps(stamps);

    ASSERT_EQ(clock.steps.size(), 1U);
    EXPECT_EQ(clock.steps[0].first_row, 60U);
    EXPECT_EQ(clock.steps[0].shift_ns, 2000 * kMillisecond_ns);
}

TEST(ClockStepsTest, AFewWrongTimestampsAreNoStep) {
    std::vector<std::int64_t> stamps = stamps_set_back(100, 0);
    stamps[40] -= 1050 * kMillisecond_ns;
    EXPECT_TRUE(find_clock_steps(stamps).steps.empty());

    stamps[41] -= 1050 * kMillisecond_ns;
    EXPECT_TRUE(find_clock_steps(stamps).steps.empty());
}

TEST(ClockStepsTest, AStepAfterAFewRowsOfACameraIsThatOfTheImu) {
    const SetBack set_back{1000, 60'000};
    const auto images = times(200, 0, 100'000);
    ASSERT_EQ(set_back.by_imu().steps.size(), 1U);

    const TableClock clock = find_clock_steps(set_back.written(images), set_back.by_imu());

    EXPECT_TRUE(clock.is_known);
    EXPECT_EQ(moved(set_back.written(images), clock), images);
}

TEST(ClockStepsTest, AStepShorterThanThePeriodOfACameraIsThatOfTheImu) {
    for (const int back_ms : {60, 400, 500, 700}) {
        const SetBack set_back{20'300, back_ms};
        auto images = times(500, 0, 100'000);
        for (std::size_t i = 0; i < images.size(); i += 3) images[i] += kMillisecond_ns;  // jitter

        const TableClock clock = find_clock_steps(set_back.written(images), set_back.by_imu());

        EXPECT_TRUE(clock.is_known) << back_ms;
        EXPECT_EQ(moved(set_back.written(images), clock), images) << back_ms;
    }
}

TEST(ClockStepsTest, ATableMayBeginAfterAStepOrEndBeforeIt) {
    const SetBack set_back{1000, 60'000};
    for (const auto& [begin_ms, end_ms] : {std::pair(3000, 50'000), std::pair(0, 900)}) {
        const auto images = times(100, begin_ms, end_ms);

        const TableClock clock = find_clock_steps(set_back.written(images), set_back.by_imu());

        EXPECT_TRUE(clock.is_known) << begin_ms;
        EXPECT_EQ(moved(set_back.written(images), clock), images) << begin_ms;
    }
}

TEST(ClockStepsTest, TwoStepsAreFoundInASlowTable) {
    const SetBack first{1000, 60'000};
    const SetBack second{30'000, 700};
    const auto written = [&](const std::vector<std::int64_t>& times_ns) {
        auto stamps_ns = first.written(times_ns);
        const auto again = second.written(times_ns);
        for (std::size_t i = 0; i < stamps_ns.size(); ++i) stamps_ns[i] += again[i] - times_ns[i];
        return stamps_ns;
    };
    const auto depths = times(1000, 300, 100'000);
    const TableClock imu = find_clock_steps(written(times(5, 0, 100'000)));
    ASSERT_EQ(imu.steps.size(), 2U);

    const TableClock clock = find_clock_steps(written(depths), imu);

    EXPECT_TRUE(clock.is_known);
    EXPECT_EQ(moved(written(depths), clock), depths);
}

TEST(ClockStepsTest, ATableWithAClockOfItsOwnIsNotMovedAndIsTold) {
    for (const int back_ms : {400, 60'000}) {
        const SetBack set_back{20'300, back_ms};
        FindingLog log;
        CommonClock common(log);
        common.add("imu0", set_back.by_imu());

        const TableClock clock = find_clock_steps(times(500, 0, 100'000), common.known());
        common.add("cam0", clock);

        EXPECT_TRUE(clock.steps.empty()) << back_ms;
        EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "clocks_disagree", "cam0"));
    }
}

// Names of images have no order but that of time: after a clock was set back by more than the dive
// lasts, they begin with the later frames.
TEST(ClockStepsTest, RowsThatWereSortedByTimeAreNotMovedAndAreTold) {
    const SetBack set_back{50'000, 600'000};
    FindingLog log;
    CommonClock common(log);
    common.add("imu0", set_back.by_imu());
    auto stamps_ns = set_back.written(times(200, 0, 100'000));
    std::sort(stamps_ns.begin(), stamps_ns.end());

    const TableClock clock = find_clock_steps(stamps_ns, common.known());
    common.add("cam0", clock);

    EXPECT_TRUE(clock.steps.empty());
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "clocks_disagree", "cam0"));
}

TEST(ClockStepsTest, TheTruthIsMovedAsTheOtherTables) {
    const SetBack set_back{10'000, 60'000};
    FindingLog log;
    CommonClock clock(log);
    clock.add("imu0", set_back.by_imu());
    auto poses = times(50, 0, 9500);  // it misses a second
    const auto later = times(50, 10'500, 100'000);
    poses.insert(poses.end(), later.begin(), later.end());
    std::string text;
    for (const std::int64_t stamp_ns : set_back.written(poses))
        text += std::to_string(stamp_ns) + "," + std::to_string(text.size()) + ",0,0,1,0,0,0\n";

    const auto truth = parse_ground_truth(text, "truth", log, &clock);

    EXPECT_EQ(timestamps_of(truth), poses);
}

TEST(ClockStepsTest, RowsOfACameraAfterTheStepKeepTheirOrderAndTheirFiles) {
    FindingLog log;
    FindingLog clock_log;
    CommonClock clock(clock_log);

    const auto rows = parse_camera_rows(camera_csv(stamps_set_back(60, 2000)), "cam0", log, &clock);

    ASSERT_EQ(rows.size(), 100U);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        EXPECT_EQ(rows[i].file, "mav0/cam0/data/" + std::to_string(i) + ".png");
        EXPECT_EQ(rows[i].timestamp_ns, stamps_set_back(100, 0)[i]);
    }
    EXPECT_EQ(clock.known().steps.size(), 1U);
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

TEST(ClockStepsTest, RowsWrittenBackwardsAreSortedWithAWarning) {
    FindingLog log;
    std::string text;
    for (int i = 20; i-- > 0;) text += imu_row((1000 + i) * kMillisecond_ns, "0,0,0,0,0,9.8");

    const auto samples = parse_imu(text, kFile, log);

    ASSERT_EQ(samples.size(), 20U);
    EXPECT_EQ(samples.front().timestamp_ns, 1000 * kMillisecond_ns);
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "imu_timestamp_backwards", "19 of 20"));
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

TEST(ClockStepsTest, AStepThatTablesShareIsToldOnce) {
    FindingLog log;
    CommonClock clock(log);
    const SetBack set_back{20'300, 2000};

    clock.add("imu0", set_back.by_imu());
    for (const char* camera : {"cam0", "cam1"})
        clock.add(camera, find_clock_steps(set_back.written(times(100, 0, 90'000)), clock.known()));

    ASSERT_EQ(log.all().size(), 1U);
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "clock_set_back", "imu0"));
}

TEST(ClockStepsTest, AnImuThatWasNotSetBackWithTheCamerasIsTold) {
    FindingLog log;
    CommonClock clock(log);
    const SetBack set_back{20'300, 2000};

    clock.add("imu0", find_clock_steps(times(5, 0, 100'000)));
    clock.add("cam0", find_clock_steps(set_back.written(times(100, 0, 90'000)), clock.known()));

    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "clock_set_back", "cam0"));
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "clocks_disagree", "imu0"));
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
