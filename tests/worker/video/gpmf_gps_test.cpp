#include "worker/video/gpmf_gps.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "tests/worker/video/gpmf_writer.hpp"

namespace divemesh::video {
namespace {

// A sample of GPS9 as the format's description lists it: latitude, longitude, altitude, speeds,
// days since 2000, seconds of the day, dilution of precision, fix.
std::string gps9_sample(double latitude_deg, double longitude_deg, unsigned dop100, unsigned lock) {
    return longs({std::llround(1e7 * latitude_deg),
                  std::llround(1e7 * longitude_deg),
                  12'345,
                  100,
                  12,
                  9617,
                  36'000'500}) +
           big_endian_bytes(dop100, 2) + big_endian_bytes(lock, 2);
}

std::string gps9_stream(const std::vector<std::string>& samples) {
    std::string values;
    for (const std::string& sample : samples) values += sample;
    return nested("STRM",
                  klv("TYPE", 'c', 1, 9, "lllllllSS") +
                      klv("SCAL",
                          'l',
                          4,
                          9,
                          longs({10'000'000, 10'000'000, 1000, 1000, 100, 1, 1000, 100, 1})) +
                      klv("GPS9", '?', 32, samples.size(), values));
}

std::optional<GpsPosition> position_of(const std::vector<std::string>& streams) {
    std::vector<GpmfPayload> payloads;
    for (const std::string& stream : streams) payloads.push_back({0, 0, device(stream)});
    return gps_position_of(payloads);
}

TEST(GpmfGpsTest, FixesOfGps5AreScaledAndSigned) {
    const auto fixes = parse_gps(device(gps5_stream(3, 150, {{13.1913, -59.6413}, {-33.9, 18.4}})));
    ASSERT_EQ(fixes.size(), 2U);
    EXPECT_NEAR(fixes[0].latitude_deg, 13.1913, 1e-7);
    EXPECT_NEAR(fixes[0].longitude_deg, -59.6413, 1e-7);
    EXPECT_NEAR(fixes[1].latitude_deg, -33.9, 1e-7);
}

TEST(GpmfGpsTest, FixesWithoutLockOrPrecisionAreNone) {
    const std::vector<std::pair<double, double>> fix = {{13.0, -59.0}};
    EXPECT_FALSE(position_of({gps5_stream(0, 100, fix), gps5_stream(3, 501, fix)}));
    EXPECT_TRUE(position_of({gps5_stream(2, 500, fix)}));
    EXPECT_FALSE(position_of({gps5_stream(3, 100, {{91.0, 0.0}, {0.0, 181.0}})}));
    EXPECT_FALSE(position_of({}));
}

TEST(GpmfGpsTest, TheMedianWithstandsAFixThatIsFarOff) {
    const auto found = position_of({gps5_stream(3, 100, {{10.0, 20.0}, {10.00001, 20.00001}}),
                                    gps5_stream(0, 9999, {{55.0, 3.0}, {55.0, 3.0}}),
                                    gps5_stream(2, 300, {{10.00002, 20.00002}, {10.5, 20.5}}),
                                    gps5_stream(2, 300, {{9.99999, 19.99999}})});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->num_fixes, 5);
    EXPECT_NEAR(found->position.latitude_deg, 10.00001, 1e-9);
    EXPECT_NEAR(found->position.longitude_deg, 20.00001, 1e-9);
    // 1e-5 degrees are 1.112 m of latitude, and 0.985 times that of longitude at 10 degrees.
    EXPECT_NEAR(found->scatter_m, 1.112 * std::hypot(1.0, 0.985), 0.01);
    EXPECT_GT(found->spread_m, 10'000.0);
    EXPECT_FALSE(found->position.x_azimuth_deg);
}

TEST(GpmfGpsTest, LongitudesAboutTheDateLineHaveAMedian) {
    const auto found = position_of(
        {gps5_stream(3, 100, {{-17.0, 179.9999}, {-17.0, -179.9998}, {-17.0, -179.9999}})});
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->position.longitude_deg, -179.9999, 1e-7);
    EXPECT_LT(found->spread_m, 30.0);
}

TEST(GpmfGpsTest, SamplesOfGps9TellTheirOwnLockAndPrecision) {
    const std::string gps9 = gps9_stream({gps9_sample(0.0, 0.0, 9999, 0),
                                          gps9_sample(-33.9, 18.4, 130, 3),
                                          gps9_sample(-33.8, 18.5, 501, 3)});
    const auto fixes = parse_gps(device(gps9));
    ASSERT_EQ(fixes.size(), 1U);
    EXPECT_NEAR(fixes[0].latitude_deg, -33.9, 1e-7);
    EXPECT_NEAR(fixes[0].longitude_deg, 18.4, 1e-7);
    // A camera that writes both is read once.
    EXPECT_EQ(parse_gps(device(gps5_stream(3, 100, {{-33.9, 18.4}}) + gps9)).size(), 1U);
}

TEST(GpmfGpsTest, WhatContradictsItselfIsLeftOut) {
    const std::string sample = gps9_sample(1.0, 2.0, 100, 3);
    const auto num_read = [](const std::string& list) {
        return parse_gps(device(nested("STRM", list))).size();
    };
    const std::string type = klv("TYPE", 'c', 1, 9, "lllllllSS");
    const std::string scale = klv("SCAL", 'l', 4, 1, longs({1}));
    EXPECT_EQ(num_read(scale + klv("GPS9", '?', 32, 1, sample)), 0U);
    EXPECT_EQ(num_read(type + klv("GPS9", '?', 32, 1, sample)), 0U);
    EXPECT_EQ(
        num_read(klv("TYPE", 'c', 1, 9, "lllllllSU") + scale + klv("GPS9", '?', 32, 1, sample)),
        0U);
    EXPECT_EQ(num_read(type + scale + klv("GPS9", '?', 30, 1, sample.substr(2))), 0U);
    EXPECT_EQ(
        num_read(type + klv("SCAL", 'l', 4, 2, longs({1, 1})) + klv("GPS9", '?', 32, 1, sample)),
        0U);
    EXPECT_EQ(num_read(type + klv("SCAL", 'l', 4, 1, longs({0})) + klv("GPS9", '?', 32, 1, sample)),
              0U);
    EXPECT_EQ(num_read(klv("GPSF", 'c', 1, 0, "") + klv("GPS5", 'c', 5, 1, "abcde")), 0U);
}

TEST(GpmfGpsTest, EveryBrokenByteLeavesPositionsOrNothing) {
    const std::string whole = device(gps5_stream(3, 100, {{13.0, -59.0}, {13.1, -59.1}}) +
                                     gps9_stream({gps9_sample(13.0, -59.0, 100, 3)}));
    cv::RNG random(7);
    for (int trial = 0; trial < 20'000; ++trial) {
        std::string bytes = whole;
        for (int k = 0; k < 3; ++k)
            bytes[static_cast<std::size_t>(random.uniform(0, static_cast<int>(bytes.size())))] =
                static_cast<char>(random.uniform(0, 256));
        const auto found = gps_position_of({{0, 0, bytes}});
        ASSERT_TRUE(!found || (found->position.is_valid() && std::isfinite(found->spread_m)));
    }
}

}  // namespace
}  // namespace divemesh::video
