#include "worker/dive/imu_frozen.hpp"

#include <gtest/gtest.h>

#include "tests/worker/dive/finding_matcher.hpp"

namespace divemesh::dive {
namespace {

// 200 Hz; no two rows are alike.
std::vector<types::ImuSample> moving(int num_rows) {
    std::vector<types::ImuSample> samples;
    for (int i = 0; i < num_rows; ++i)
        samples.push_back({i * 5'000'000LL, {0.01 * (i % 7), 0.001 * i, 0.0}, {0.0, 0.0, 9.8}});
    return samples;
}

void freeze(std::vector<types::ImuSample>& samples, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
        samples[i].angular_velocity_imu = samples[begin].angular_velocity_imu;
        samples[i].acceleration_imu = samples[begin].acceleration_imu;
    }
}

TEST(ImuFrozenTest, RowsOfASensorThatHangsAreLeftOut) {
    auto samples = moving(400);
    freeze(samples, 100, 200);
    FindingLog log;

    leave_out_frozen_readings(samples, "imu", log);

    ASSERT_EQ(samples.size(), 301U);
    EXPECT_EQ(samples[100].timestamp_ns, 500'000'000);
    EXPECT_EQ(samples[101].timestamp_ns, 1'000'000'000);
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "imu_frozen", "99 of 400"));
}

TEST(ImuFrozenTest, AnAccelerometerMayHangAlone) {
    auto samples = moving(800);
    for (std::size_t i = 0; i < samples.size(); ++i)
        samples[i].acceleration_imu.x() = 0.01 * static_cast<double>(i % 5);
    const auto hang = [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            samples[i].acceleration_imu = samples[begin].acceleration_imu;
    };
    hang(100, 200);  // half a second: a coarse one at rest
    hang(300, 599);
    FindingLog log;

    leave_out_frozen_readings(samples, "imu", log);

    EXPECT_EQ(samples.size(), 800U - 298U);
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "imu_frozen", "298 of 800"));
}

TEST(ImuFrozenTest, RowsThatARecorderWritesTwiceStay) {
    auto samples = moving(400);
    for (std::size_t i = 0; i < samples.size(); i += 4) freeze(samples, i, i + 4);
    FindingLog log;

    leave_out_frozen_readings(samples, "imu", log);

    EXPECT_EQ(samples.size(), 400U);
    EXPECT_TRUE(log.all().empty());
}

TEST(ImuFrozenTest, ReadingsThatNeverChangeAreNoFault) {
    auto samples = moving(400);
    freeze(samples, 0, 400);
    FindingLog log;

    leave_out_frozen_readings(samples, "imu", log);

    EXPECT_EQ(samples.size(), 400U);
}

}  // namespace
}  // namespace divemesh::dive
