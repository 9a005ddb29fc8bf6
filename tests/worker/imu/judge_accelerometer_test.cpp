#include "worker/imu/judge_accelerometer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/synthetic/inertial_motion.hpp"

namespace divemesh::imu {
namespace {

constexpr int kNumFrames = 120;  // at 10 Hz

// Returns a rig that rolls and pitches by up to 15 degrees and surges by 10 cm.
Eigen::Isometry3d T_world_body(double t_s) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = (base::rotation_from_vector({0.25 * std::sin(0.9 * t_s), 0, 0}) *
                     base::rotation_from_vector({0, 0.2 * std::sin(0.6 * t_s), 0.1 * t_s}))
                        .toRotationMatrix();
    pose.translation() << 0.2 * t_s, 0.1 * std::sin(1.2 * t_s), 0.05 * std::cos(0.8 * t_s);
    return pose;
}

// Returns the disagreement over a dive whose accelerations `wrong` changes; vision loses the scene
// at every `lost`-th frame.
template <typename Wrong>
std::optional<double> disagreement(const Wrong& wrong, int lost = kNumFrames) {
    ImuBias bias;
    bias.accelerometer << 0.08, -0.05, 0.1;
    std::vector<types::ImuSample> samples =
        synthetic::imu_along(T_world_body, -0.5, 0.1 * kNumFrames + 0.5, bias);
    for (types::ImuSample& sample : samples) wrong(sample.acceleration_imu);
    GravityByVision gravity(samples);
    for (int k = 1; k <= kNumFrames; ++k) {
        if (k % lost == 0) continue;
        const double from_s = 0.1 * (k - 1);
        const double to_s = 0.1 * k;
        gravity.add({std::llround(1e9 * from_s),
                     std::llround(1e9 * to_s),
                     T_world_body(from_s).inverse() * T_world_body(to_s)});
    }
    return gravity.disagreement_m_s2();
}

void as_measured(Eigen::Vector3d&) {}

TEST(JudgeAccelerometerTest, ABiasedAccelerometerFits) {
    const auto found = disagreement(as_measured);
    ASSERT_TRUE(found);
    EXPECT_LT(*found, 0.1);
}

TEST(JudgeAccelerometerTest, AReversedSignIsOnlyAnotherVertical) {
    // The direction of gravity is estimated, so only the accelerations are wrong: by twice 0.15 at
    // most, and two of them differ by twice that.
    const auto found = disagreement([](Eigen::Vector3d& force) { force = -force; });
    ASSERT_TRUE(found);
    EXPECT_LT(*found, 0.6);
}

TEST(JudgeAccelerometerTest, ExchangedAxesContradict) {
    const auto found =
        disagreement([](Eigen::Vector3d& force) { std::swap(force.x(), force.y()); });
    ASSERT_TRUE(found);
    EXPECT_GT(*found, 2.0 * kMaxGravityDisagreement_m_s2);
}

TEST(JudgeAccelerometerTest, AMirroredAxisContradicts) {
    const auto found = disagreement([](Eigen::Vector3d& force) { force.x() = -force.x(); });
    ASSERT_TRUE(found);
    EXPECT_GT(*found, 2.0 * kMaxGravityDisagreement_m_s2);
}

// Returns the samples of half a minute whose accelerations `wrong` changes.
template <typename Wrong>
std::vector<types::ImuSample> half_a_minute(const Wrong& wrong) {
    std::vector<types::ImuSample> samples = synthetic::imu_along(T_world_body, -0.5, 30.5, {});
    for (types::ImuSample& sample : samples) wrong(sample);
    return samples;
}

// Shows half a minute to `gravity` at a frame rate. Each motion by vision has an error of its own.
void watch(double rate_hz, double sigma_m, double sigma_rad, GravityByVision& gravity) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    const auto drawn = [&](double sigma) {
        return Eigen::Vector3d(
            sigma * normal(random), sigma * normal(random), sigma * normal(random));
    };
    for (int k = 1; k <= std::lround(30.0 * rate_hz); ++k) {
        const double from_s = (k - 1) / rate_hz;
        const double to_s = k / rate_hz;
        Eigen::Isometry3d T_from_to = T_world_body(from_s).inverse() * T_world_body(to_s);
        T_from_to.translation() += drawn(sigma_m);
        T_from_to.rotate(base::rotation_from_vector(drawn(sigma_rad)));
        gravity.add({std::llround(1e9 * from_s), std::llround(1e9 * to_s), T_from_to});
    }
}

class GravityAtRateTest : public testing::TestWithParam<double> {};

TEST_P(GravityAtRateTest, TheNoiseOfCloseFramesIsNoContradiction) {
    const auto samples = half_a_minute([](types::ImuSample&) {});
    GravityByVision gravity(samples);
    watch(GetParam(), 0.003, 0.001, gravity);
    ASSERT_TRUE(gravity.disagreement_m_s2());
    EXPECT_LT(*gravity.disagreement_m_s2(), kMaxGravityDisagreement_m_s2);
    EXPECT_TRUE(gravity.wrong_times().empty());
}

TEST_P(GravityAtRateTest, ExchangedAxesAreSeenThroughIt) {
    const auto samples = half_a_minute([](types::ImuSample& sample) {
        std::swap(sample.acceleration_imu.y(), sample.acceleration_imu.z());
    });
    GravityByVision gravity(samples);
    watch(GetParam(), 0.003, 0.001, gravity);
    ASSERT_TRUE(gravity.disagreement_m_s2());
    EXPECT_GT(*gravity.disagreement_m_s2(), kMaxGravityDisagreement_m_s2);
}

TEST_P(GravityAtRateTest, FindsTheTimeInWhichTheAccelerometerIsWrong) {
    const auto samples = half_a_minute([](types::ImuSample& sample) {
        if (sample.timestamp_ns > 12'000'000'000 && sample.timestamp_ns < 16'000'000'000)
            sample.acceleration_imu << 0.0, 5.0, 8.0;
    });
    GravityByVision gravity(samples);
    watch(GetParam(), 0.003, 0.001, gravity);
    const auto times = gravity.wrong_times();
    ASSERT_EQ(times.size(), 1U);
    EXPECT_LE(times[0].from_ns, 12'000'000'000);
    EXPECT_GE(times[0].from_ns, 9'500'000'000);
    EXPECT_GE(times[0].to_ns, 16'000'000'000);
    EXPECT_LE(times[0].to_ns, 18'500'000'000);
}

INSTANTIATE_TEST_SUITE_P(Rates, GravityAtRateTest, testing::Values(5.0, 10.0, 20.0, 30.0));

TEST(JudgeAccelerometerTest, VisionThatIsLostEveryFewSecondsTellsNothing) {
    EXPECT_FALSE(disagreement(as_measured, 30));
}

}  // namespace
}  // namespace divemesh::imu
