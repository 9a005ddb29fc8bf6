#include "worker/dive/clipped_readings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/worker/dive/finding_matcher.hpp"
#include "worker/base/seconds.hpp"
#include "worker/dive/imu_clipped.hpp"
#include "worker/imu/imu_steps.hpp"

namespace divemesh::dive {
namespace {

constexpr double kNoise = 0.01;

// 30 s at 200 Hz: a sway of up to 1 rad/s and 12 m/s^2, `step` apart as the sensor tells them.
std::vector<types::ImuSample> swaying(double step) {
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0.0, kNoise);
    const auto told = [&](double value) {
        return step > 0.0 ? step * std::round(value / step) : value + noise(random);
    };
    std::vector<types::ImuSample> samples;
    for (int i = 0; i < 6000; ++i) {
        const double t_s = 0.005 * i;
        const double sway = std::sin(2.0 * t_s) + 0.2 * std::sin(0.31 * t_s);
        samples.push_back({i * std::int64_t{5'000'000},
                           {told(0.8 * sway), told(0.1 * sway), told(0.0)},
                           {told(1.0 * sway), told(0.0), told(9.8 + 2.0 * sway)}});
    }
    return samples;
}

void clip(std::vector<types::ImuSample>& samples, double rate, double force) {
    for (types::ImuSample& sample : samples) {
        sample.angular_velocity_imu =
            sample.angular_velocity_imu.cwiseMax(-rate).cwiseMin(rate).eval();
        sample.acceleration_imu = sample.acceleration_imu.cwiseMax(-force).cwiseMin(force).eval();
    }
}

TEST(ClippedReadingsTest, ASensorWithinItsRangeIsNotClipped) {
    for (const double step : {0.0, 0.001, 0.005}) {
        EXPECT_TRUE(clipped_rates(swaying(step)).rows.empty()) << step;
        EXPECT_TRUE(clipped_forces(swaying(step)).rows.empty()) << step;
    }
}

TEST(ClippedReadingsTest, ACoarseSensorAtRestIsNotClipped) {
    std::vector<types::ImuSample> samples;
    for (int i = 0; i < 2000; ++i)
        samples.push_back({i * std::int64_t{5'000'000},
                           {i / 5 % 2 == 0 ? 0.0 : 0.04, 0.0, 0.0},
                           {0.0, 0.0, i / 7 % 2 == 0 ? 9.8 : 9.84}});
    EXPECT_TRUE(clipped_rates(samples).rows.empty());
    EXPECT_TRUE(clipped_forces(samples).rows.empty());
}

TEST(ClippedReadingsTest, ClippedRowsAreFoundWithTheirLimit) {
    for (const double step : {0.0, 0.001}) {
        auto samples = swaying(step);
        const auto free = samples;
        clip(samples, 0.7, 10.5);
        const ClippedReadings rates = clipped_rates(samples);
        const ClippedReadings forces = clipped_forces(samples);
        EXPECT_NEAR(rates.limit, 0.7, 1e-9);
        EXPECT_NEAR(forces.limit, 10.5, 1e-9);
        for (const auto* clipped : {&rates, &forces}) {
            std::vector<std::size_t> beyond;
            for (std::size_t i = 0; i < free.size(); ++i)
                if (clipped == &rates ? std::abs(free[i].angular_velocity_imu.x()) >= 0.7 - 1e-12
                                      : free[i].acceleration_imu.z() >= 10.5 - 1e-12)
                    beyond.push_back(i);
            EXPECT_EQ(clipped->rows, beyond);
            EXPECT_TRUE(clipped->spoil(samples.size()));
        }
    }
}

TEST(ClippedReadingsTest, AnAxisThatIsClippedMostOfTheTimeIsFound) {
    auto samples = swaying(0.0);
    clip(samples, 9.0, 9.5);
    const ClippedReadings forces = clipped_forces(samples);
    EXPECT_GT(forces.rows.size(), samples.size() / 2);
    EXPECT_TRUE(clipped_rates(samples).rows.empty());
}

// Three shakes beyond the range, of 20 ms each.
TEST(ClippedReadingsTest, NoMotionIsIntegratedAcrossRowsThatAreLeftOut) {
    for (const bool is_gyroscope : {true, false}) {
        auto samples = swaying(0.0);
        const std::size_t num_rows = samples.size();
        for (const std::size_t first : {1000, 2000, 3000})
            for (std::size_t i = first; i < first + 4; ++i)
                (is_gyroscope ? samples[i].angular_velocity_imu : samples[i].acceleration_imu).x() =
                    30.0;
        FindingLog findings;

        leave_out_clipped_readings(samples, "data.csv", findings);

        EXPECT_THAT(findings.all(), HasFinding(Severity::Warning, "imu_clipped", "12 of 6000"));
        EXPECT_LT(num_rows - samples.size(), 130U);
        const auto integrates = [&](double from_s, double to_s) {
            return !imu::for_each_step(
                samples, base::to_ns(from_s), base::to_ns(to_s), [](auto&&...) {});
        };
        for (const double clipped_s : {5.0, 10.0, 15.0})
            EXPECT_FALSE(integrates(clipped_s - 0.2, clipped_s + 0.2)) << clipped_s;
        EXPECT_TRUE(integrates(5.2, 9.8));
    }
}

}  // namespace
}  // namespace divemesh::dive
