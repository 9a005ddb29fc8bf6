#include "worker/imu/judge_accelerometer.hpp"

#include <gtest/gtest.h>

#include <cmath>

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
    // The direction of gravity is estimated, so only the accelerations are wrong, by twice 0.1.
    const auto found = disagreement([](Eigen::Vector3d& force) { force = -force; });
    ASSERT_TRUE(found);
    EXPECT_LT(*found, kMaxGravityDisagreement_m_s2);
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

TEST(JudgeAccelerometerTest, VisionThatIsLostEveryFewSecondsTellsNothing) {
    EXPECT_FALSE(disagreement(as_measured, 30));
}

}  // namespace
}  // namespace divemesh::imu
