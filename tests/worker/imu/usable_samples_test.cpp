#include "worker/imu/usable_samples.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/sensor_recording.hpp"

namespace divemesh::imu {
namespace {

// Returns a recording with a sample at every second from 0 to 9.
synthetic::SensorRecording ten_seconds() {
    synthetic::SensorRecording recording;
    for (std::int64_t second = 0; second < 10; ++second) {
        types::ImuSample sample;
        sample.timestamp_ns = second * 1'000'000'000;
        recording.its_imu.push_back(sample);
    }
    return recording;
}

TEST(UsableSamplesTest, ATimeIsLeftOutOfBoth) {
    const auto recording = ten_seconds();
    types::SensorsLeftOut left_out;
    left_out.imu_times = {{3'000'000'000, 5'500'000'000}};
    EXPECT_EQ(usable_rates(recording, left_out).size(), 7U);
    EXPECT_EQ(usable_forces(recording, left_out).size(), 7U);
}

TEST(UsableSamplesTest, AnAccelerometerLeavesTheGyroscope) {
    const auto recording = ten_seconds();
    types::SensorsLeftOut left_out;
    left_out.accelerometer = true;
    EXPECT_EQ(usable_rates(recording, left_out).size(), 10U);
    EXPECT_TRUE(usable_forces(recording, left_out).empty());
}

TEST(UsableSamplesTest, AnImuThatIsLeftOutHasNone) {
    const auto recording = ten_seconds();
    types::SensorsLeftOut left_out;
    left_out.imu = true;
    EXPECT_TRUE(usable_rates(recording, left_out).empty());
    EXPECT_TRUE(usable_forces(recording, left_out).empty());
}

}  // namespace
}  // namespace divemesh::imu
