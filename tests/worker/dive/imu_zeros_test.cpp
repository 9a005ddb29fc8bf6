#include "worker/dive/imu_zeros.hpp"

#include <gtest/gtest.h>

#include "tests/worker/dive/finding_matcher.hpp"

namespace divemesh::dive {
namespace {

constexpr std::int64_t kPeriod_ns = 5'000'000;

// 200 Hz, turning at 0.1 to 0.3 rad/s, with an acceleration that rises by 0.01 m/s^2 a row.
std::vector<types::ImuSample> turning(int num_rows) {
    std::vector<types::ImuSample> samples;
    for (int i = 0; i < num_rows; ++i)
        samples.push_back({i * kPeriod_ns, {0.1 + 0.002 * i, 0.0, 0.0}, {0.01 * i, 0.0, 9.8}});
    return samples;
}

TEST(ImuZerosTest, ReadingsAtSeparateTimesAreJoinedAtTheTimesOfTheGyroscope) {
    const auto truth = turning(100);
    auto samples = truth;
    for (std::size_t i = 0; i < samples.size(); ++i)
        (i % 2 == 0 ? samples[i].angular_velocity_imu : samples[i].acceleration_imu).setZero();
    FindingLog log;

    fill_zero_readings(samples, "imu", log);

    // The first row has no rate beside it, the last no acceleration after it.
    for (const types::ImuSample& sample : samples) {
        const auto& expected = truth[static_cast<std::size_t>(sample.timestamp_ns / kPeriod_ns)];
        if (sample.timestamp_ns == 0) continue;
        EXPECT_EQ(sample.angular_velocity_imu, expected.angular_velocity_imu);
        EXPECT_LT((sample.acceleration_imu - expected.acceleration_imu).norm(), 1e-9);
    }
    EXPECT_EQ(samples.size(), 50U);
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "imu_zeros", "rows are left out"));
}

TEST(ImuZerosTest, ALongDropoutIsLeftOutAndNotInvented) {
    auto samples = turning(100);
    for (std::size_t i = 40; i < 60; ++i) {
        samples[i].angular_velocity_imu.setZero();
        samples[i].acceleration_imu.setZero();
    }
    FindingLog log;

    fill_zero_readings(samples, "imu", log);

    EXPECT_EQ(samples.size(), 80U);
    EXPECT_THAT(log.all(), HasFinding(Severity::Warning, "imu_zeros", "20 of 100"));
}

TEST(ImuZerosTest, AGyroscopeThatReadsZeroAtRestIsBelieved) {
    auto samples = turning(100);
    for (types::ImuSample& sample : samples) sample.angular_velocity_imu = {0.001, 0.0, 0.0};
    for (std::size_t i = 10; i < 90; ++i) samples[i].angular_velocity_imu.setZero();
    FindingLog log;

    fill_zero_readings(samples, "imu", log);

    EXPECT_EQ(samples.size(), 100U);
    EXPECT_TRUE(log.all().empty());
}

}  // namespace
}  // namespace divemesh::dive
