#include "worker/pipeline/known_motions.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/synthetic/sensor_recording.hpp"
#include "worker/loops/motions_in_sight.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr double kOdometryMoved_m = 0.001;

Eigen::Isometry3d at(double x_m) { return Eigen::Isometry3d(Eigen::Translation3d(x_m, 0.0, 0.0)); }

// A rig that rests from 1 s to 9 s between its first two keyframes and swims to the third. The
// adjustment has moved the second one by 5 cm.
class KnownMotionsTest : public testing::Test {
protected:
    KnownMotionsTest() {
        for (int i = 0; i <= 20; ++i)
            track_.odometry.push_back(
                {i * kSecond_ns, at(i == 0 ? 0.0 : kOdometryMoved_m + 0.1 * std::max(0, i - 10))});
        track_.keyframes = {
            {0, 0, at(0.0)}, {10, 10 * kSecond_ns, at(0.05)}, {20, 20 * kSecond_ns, at(1.0)}};
        track_.landmarks.assign(50, {Eigen::Vector3d::Zero(), {{0}, {1}, {2}}});
        track_.rests = {{kSecond_ns, 9 * kSecond_ns, 0.002, 0.003}};
        track_.motions.assign(21, types::MotionSource::Nothing);
        track_.sigmas.assign(21, {});
    }
    std::vector<optimisation::KnownMotion> motions() const {
        const imu::InertialPrior inertial(recording_, {});
        const loops::DriftModel drift(
            track_.keyframes, track_.landmarks, &inertial, loops::motions_in_sight(track_));
        return known_motions(track_, track_, inertial, drift);
    }

    types::Track track_;
    synthetic::SensorRecording recording_;
};

TEST_F(KnownMotionsTest, ARestBetweenTwoKeyframesConnectsThem) {
    const auto known = motions();
    ASSERT_EQ(known.size(), 1U);
    EXPECT_EQ(known[0].to, 1U);
    EXPECT_NEAR(known[0].T_before_to.translation().x(), kOdometryMoved_m, 1e-12);
    EXPECT_NEAR(known[0].sigma_m, std::sqrt(2.0) * 0.002, 1e-12);
    EXPECT_NEAR(known[0].sigma_rad, std::sqrt(2.0) * 0.003, 1e-12);
}

TEST_F(KnownMotionsTest, ARestConnectsAllKeyframesWithinIt) {
    track_.rests[0].to_ns = 25 * kSecond_ns;
    const auto known = motions();
    ASSERT_EQ(known.size(), 2U);
    EXPECT_EQ(known[0].to, 1U);
    EXPECT_EQ(known[1].to, 2U);
    EXPECT_NEAR(known[1].sigma_m, std::sqrt(2.0) * 0.002, 1e-12);
}

TEST_F(KnownMotionsTest, ARestThatEndsLongBeforeTheNextKeyframeDoesNotConnectThem) {
    track_.rests[0].to_ns = 7 * kSecond_ns;
    EXPECT_TRUE(motions().empty());
    track_.rests[0] = {3 * kSecond_ns, 9 * kSecond_ns, 0.002, 0.003};
    EXPECT_TRUE(motions().empty());
}

TEST_F(KnownMotionsTest, ARestThatBeginsAfterTheNextKeyframeDoesNotConnectThem) {
    track_.keyframes[1].timestamp_ns = kSecond_ns;
    track_.rests = {{kSecond_ns, 9 * kSecond_ns, 0.002, 0.003}};
    EXPECT_TRUE(motions().empty());
}

TEST_F(KnownMotionsTest, FramesInSightGiveTheMotionWhereNoLandmarksDo) {
    for (types::Landmark& landmark : track_.landmarks) landmark.observations.pop_back();
    track_.motions.assign(21, types::MotionSource::Vision);
    track_.sigmas.assign(21, {0.004, 0.001});
    const auto known = motions();
    ASSERT_EQ(known.size(), 2U);
    EXPECT_EQ(known[1].to, 2U);
    EXPECT_NEAR(known[1].T_before_to.translation().x(), 1.0, 1e-12);
    EXPECT_NEAR(known[1].sigma_m, std::sqrt(10.0) * 0.004, 1e-12);
    EXPECT_NEAR(known[1].sigma_rad, std::sqrt(10.0) * 0.001, 1e-12);
}

TEST_F(KnownMotionsTest, AnUnmeasuredMotionIsThePredictedOne) {
    for (types::Landmark& landmark : track_.landmarks) landmark.observations.pop_back();
    const auto known = motions();
    ASSERT_EQ(known.size(), 2U);
    EXPECT_EQ(known[1].to, 2U);
    EXPECT_NEAR(known[1].T_before_to.translation().x(), 0.95, 1e-12);
    EXPECT_GT(known[1].sigma_m, 0.1);
}

}  // namespace
}  // namespace divemesh::pipeline
