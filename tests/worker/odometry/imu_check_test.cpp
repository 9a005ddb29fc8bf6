#include "worker/odometry/imu_check.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/stereo_world.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::int64_t kInterval_ns = 100'000'000;
constexpr int kNumSteps = 8;

Eigen::Isometry3d true_motion(int step) {
    return synthetic::T_world_cam(step + 1).inverse() * synthetic::T_world_cam(step);
}

types::TimeInterval time_of(int step) { return {step * kInterval_ns, (step + 1) * kInterval_ns}; }

// What vision measures of a step of the synthetic dive.
Registration seen(int step) {
    synthetic::World world(1.0, 0.0, static_cast<unsigned>(step) + 1);
    const types::Features previous = world.see(synthetic::T_world_cam(step), step, 0.2);
    const types::Features current = world.see(synthetic::T_world_cam(step + 1), step + 1, 0.2);
    return register_points(
        synthetic::rig(), with_depth_at_both_times(synthetic::rig(), previous, current), 2.0, 1);
}

// The rotation of a step by a gyroscope that errs about the camera's y.
types::KnownRotation by_gyroscope(int step, double error_rad) {
    return {base::rotation_from_vector({0.0, error_rad, 0.0}) *
                Eigen::Quaterniond(true_motion(step).linear()),
            1e-4};
}

// Returns the step at which a bias is found that began at step 0; kNumSteps if it is not.
int found_at(double bias_rad_s) {
    ImuCheck check(synthetic::rig(), {});
    for (int step = 0; step < kNumSteps; ++step)
        if (check.contradicts(seen(step), by_gyroscope(step, 0.1 * bias_rad_s), time_of(step)))
            return step;
    return kNumSteps;
}

TEST(ImuCheckTest, AGyroscopeThatFitsIsBelieved) { EXPECT_EQ(found_at(0.0), kNumSteps); }

TEST(ImuCheckTest, ALargeErrorIsFoundAtOnce) { EXPECT_EQ(found_at(0.5), 0); }

TEST(ImuCheckTest, ASmallerBiasIsFoundBySeveralSteps) {
    const int at = found_at(0.025);
    EXPECT_GT(at, 0);
    EXPECT_LT(at, 5) << "half a second";
}

// The axes of a rig are not known better.
TEST(ImuCheckTest, ATinyBiasIsNoContradiction) { EXPECT_EQ(found_at(0.01), kNumSteps); }

TEST(ImuCheckTest, FewPairsHaveNoSay) {
    ImuCheck check(synthetic::rig(), {});
    Registration vision = seen(0);
    vision.num_pairs = 2 * vision.inliers.size();
    EXPECT_FALSE(check.contradicts(vision, by_gyroscope(0, 0.05), time_of(0)));
    vision = seen(0);
    vision.inliers.resize(20);
    vision.num_pairs = 20;
    EXPECT_FALSE(check.contradicts(vision, by_gyroscope(0, 0.05), time_of(0)));
}

TEST(ImuCheckTest, OnlyAPredictionOfOtherPlacesMisledTheSearch) {
    const Registration vision = seen(0);
    const auto turned_by = [](double angle_rad) {
        return Eigen::Isometry3d(base::rotation_from_vector({0.0, angle_rad, 0.0}) *
                                 true_motion(0));
    };
    EXPECT_FALSE(is_elsewhere(synthetic::rig(), vision, true_motion(0)));
    EXPECT_FALSE(is_elsewhere(synthetic::rig(), vision, turned_by(0.002)));
    EXPECT_TRUE(is_elsewhere(synthetic::rig(), vision, turned_by(0.05)));
    Eigen::Isometry3d T_beside = true_motion(0);
    T_beside.translation().x() += 0.2;
    EXPECT_TRUE(is_elsewhere(synthetic::rig(), vision, T_beside));
    EXPECT_FALSE(is_elsewhere(synthetic::rig(), Registration{}, turned_by(0.05)));
}

TEST(ImuCheckTest, AForceThatDoublesContradicts) {
    const ImuCheck check(synthetic::rig(), {});
    const auto moved = [](double error_m) {
        Eigen::Isometry3d T_previous_current = true_motion(0).inverse();
        T_previous_current.translation().y() += error_m;
        return T_previous_current.inverse();
    };
    EXPECT_FALSE(check.contradicts(seen(0), moved(0.002), 0.1, time_of(0)));
    EXPECT_TRUE(check.contradicts(seen(0), moved(0.5 * 9.81 * 0.1 * 0.1), 0.1, time_of(0)));
}

}  // namespace
}  // namespace divemesh::odometry
