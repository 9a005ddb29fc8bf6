#include "worker/video/gpmf.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <opencv2/core.hpp>

#include "tests/worker/video/gpmf_writer.hpp"
#include "worker/video/gpmf_imu.hpp"

namespace divemesh::video {
namespace {

TEST(GpmfTest, TheExampleOfTheDescriptionIsReadWithItsScale) {
    // Accelerometer of a HERO5 (up/down, right/left, forward/back), as the description prints it.
    const auto motion = parse_gpmf(device(sensor_stream("ACCL", 418, "", 196, {4418, -628, -571})));
    ASSERT_EQ(motion.accelerometer.values.size(), 1U);
    EXPECT_FALSE(motion.is_damaged);
    // Its data are in the order Z, X, Y.
    const Eigen::Vector3d expected(-628 / 418.0, -571 / 418.0, 4418 / 418.0);
    EXPECT_LT((motion.accelerometer.values[0] - expected).norm(), 1e-12);
    EXPECT_EQ(motion.accelerometer.num_until_here, 196);
    EXPECT_TRUE(motion.gyroscope.values.empty());
}

TEST(GpmfTest, AxesAndSignsAreThoseOfOrin) {
    // "YxZ" of a HERO7 means Y, minus X, Z.
    const auto motion =
        parse_gpmf(device(sensor_stream("GYRO", 1, "YxZ", 2, {1, 2, 3, 10, 20, 30})));
    ASSERT_EQ(motion.gyroscope.values.size(), 2U);
    EXPECT_EQ(motion.gyroscope.values[0], Eigen::Vector3d(-2, 1, 3));
    EXPECT_EQ(motion.gyroscope.values[1], Eigen::Vector3d(-20, 10, 30));
}

TEST(GpmfTest, FloatsAndAScaleForEachAxisAreRead) {
    std::string values;
    for (const float value : {1.5F, -2.0F, 8.0F})
        values += big_endian_bytes(std::bit_cast<std::uint32_t>(value), 4);
    const std::string stream =
        nested("STRM",
               klv("ORIN", 'c', 1, 3, "XYZ") + klv("SCAL", 's', 2, 3, shorts({1, 2, 4})) +
                   klv("GYRO", 'f', 12, 1, values));
    const auto motion = parse_gpmf(device(stream));
    ASSERT_EQ(motion.gyroscope.values.size(), 1U);
    EXPECT_EQ(motion.gyroscope.values[0], Eigen::Vector3d(1.5, -1.0, 2.0));
}

TEST(GpmfTest, WhatContradictsItselfIsLeftOut) {
    const auto num_read = [](const std::string& stream) {
        return parse_gpmf(device(stream)).gyroscope.values.size();
    };
    EXPECT_EQ(num_read(sensor_stream("GYRO", 0, "XYZ", 1, {1, 2, 3})), 0U);  // infinite
    EXPECT_EQ(num_read(sensor_stream("GYRO", 1, "XXZ", 1, {1, 2, 3})), 0U);  // X twice
    EXPECT_EQ(num_read(sensor_stream("GYRO", 1, "XY", 1, {1, 2, 3})), 0U);
    EXPECT_EQ(num_read(sensor_stream("GYRO", 1, "ABC", 1, {1, 2, 3})), 0U);
    EXPECT_EQ(num_read(nested("STRM",
                              klv("SCAL", 's', 2, 2, shorts({1, 2})) +
                                  klv("GYRO", 's', 6, 1, shorts({1, 2, 3})))),
              0U);
    EXPECT_EQ(num_read(nested("STRM", klv("GYRO", 'c', 6, 1, "abcdef"))), 0U);
    EXPECT_EQ(num_read(nested("STRM", klv("GYRO", 's', 5, 1, "abcde"))), 0U);
    EXPECT_EQ(num_read(nested("STRM", klv("GYRO", 's', 0, 65535, ""))), 0U);
    const std::string nan = big_endian_bytes(0x7FC00000U, 4);
    EXPECT_EQ(num_read(nested("STRM", klv("GYRO", 'f', 12, 1, nan + nan + nan))), 0U);
}

TEST(GpmfTest, LengthsBeyondTheBytesAndDepthEndTheReading) {
    const std::string whole = device(sensor_stream("GYRO", 1, "XYZ", 2, {1, 2, 3, 4, 5, 6}));
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const GpmfMotion motion = parse_gpmf(std::string_view(whole).substr(0, size));
        EXPECT_TRUE(motion.is_damaged || size == 0) << size;
        EXPECT_TRUE(motion.gyroscope.values.empty()) << size;
    }
    std::string deep;
    for (int i = 0; i < 5000; ++i) deep = nested("DEVC", deep).substr(0, 200'000);
    parse_gpmf(deep);
    EXPECT_TRUE(parse_gpmf(klv("GYRO", 's', 255, 65535, "")).is_damaged);
}

TEST(GpmfTest, EveryBrokenByteLeavesNumbersOrNothing) {
    const std::string whole = device(sensor_stream("ACCL", 418, "zXy", 2, {1, 2, 3, 4, 5, 6}) +
                                     sensor_stream("GYRO", 939, "ZXY", 2, {1, 2, 3, 4, 5, 6}));
    cv::RNG random(3);
    for (int trial = 0; trial < 20'000; ++trial) {
        std::string bytes = whole;
        for (int k = 0; k < 3; ++k)
            bytes[static_cast<std::size_t>(random.uniform(0, static_cast<int>(bytes.size())))] =
                static_cast<char>(random.uniform(0, 256));
        const GpmfMotion motion = parse_gpmf(bytes);
        for (const auto* sensor : {&motion.gyroscope, &motion.accelerometer})
            for (const Eigen::Vector3d& value : sensor->values) ASSERT_TRUE(value.allFinite());
    }
}

// Payloads of a second each. The gyroscope runs at 403.846 Hz and reports its sample's number, the
// accelerometer at 201.923 Hz; payloads are written up to 8 ms late.
std::vector<GpmfPayload> jittered_payloads(int num_payloads) {
    constexpr double kGyro_hz = 403.846;
    constexpr double kAccel_hz = 201.923;
    cv::RNG random(5);
    std::vector<GpmfPayload> payloads;
    int next_gyro = 0;
    int next_accel = 0;
    for (int k = 0; k < num_payloads; ++k) {
        // Samples that the sensor has ready when the payload is written stay in it.
        const double late_s = k + 1 == num_payloads ? 0.0 : random.uniform(-0.008, 0.008);
        std::vector<int> gyro;
        std::vector<int> accel;
        for (; next_gyro / kGyro_hz < k + 1 + late_s; ++next_gyro)
            gyro.insert(gyro.end(), {next_gyro, 0, 0});
        for (; next_accel / kAccel_hz < k + 1 + late_s; ++next_accel)
            accel.insert(accel.end(), {next_accel, 0, 0});
        payloads.push_back(
            {1'000'000'000LL * k,
             1'000'000'000,
             device(
                 sensor_stream("GYRO", 1, "XYZ", static_cast<std::uint32_t>(next_gyro), gyro) +
                 sensor_stream("ACCL", 1, "XYZ", static_cast<std::uint32_t>(next_accel), accel))});
    }
    return payloads;
}

TEST(GpmfImuTest, SamplesHaveTheTimesOfASteadyClock) {
    const GpmfImu imu = imu_of(jittered_payloads(60));
    ASSERT_GT(imu.samples.size(), 24'000U);
    for (const types::ImuSample& sample : imu.samples) {
        const double time_s = 1e-9 * static_cast<double>(sample.timestamp_ns);
        ASSERT_NEAR(time_s, sample.angular_velocity_imu.x() / 403.846, 0.004);
        // The accelerometer's number at that time, between two of its samples.
        ASSERT_NEAR(sample.acceleration_imu.x() / 201.923, time_s, 0.004);
    }
}

TEST(GpmfImuTest, ALostPayloadLeavesAGapAndNoShift) {
    auto payloads = jittered_payloads(60);
    payloads.erase(payloads.begin() + 20, payloads.begin() + 23);
    const GpmfImu imu = imu_of(payloads);
    for (const types::ImuSample& sample : imu.samples)
        ASSERT_NEAR(1e-9 * static_cast<double>(sample.timestamp_ns),
                    sample.angular_velocity_imu.x() / 403.846,
                    0.004);
}

TEST(GpmfImuTest, OneSensorAloneOrNothingIsNoImu) {
    const std::string gyro = device(sensor_stream("GYRO", 1, "XYZ", 2, {1, 2, 3, 4, 5, 6}));
    EXPECT_TRUE(imu_of({{0, 1'000'000'000, gyro}}).samples.empty());
    EXPECT_TRUE(imu_of({}).samples.empty());
    EXPECT_TRUE(imu_of({{0, 0, ""}, {0, 0, "x"}}).is_damaged);
}

TEST(GpmfImuTest, StampsThatDoNotRiseStayInOrder) {
    const std::string both =
        device(sensor_stream("GYRO", 1, "XYZ", 0xFFFFFFFFU, {1, 2, 3, 4, 5, 6}) +
               sensor_stream("ACCL", 1, "XYZ", 7, {1, 2, 3, 4, 5, 6}));
    const GpmfImu imu = imu_of({{5'000'000'000, 1, both},
                                {5'000'000'000, 0, both},
                                {-9'000'000'000'000'000, 1'000'000'000, both}});
    for (std::size_t i = 1; i < imu.samples.size(); ++i)
        EXPECT_GT(imu.samples[i].timestamp_ns, imu.samples[i - 1].timestamp_ns);
}

}  // namespace
}  // namespace divemesh::video
