#include <gtest/gtest.h>

#include <functional>
#include <numbers>
#include <optional>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/pose_near.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "worker/optimisation/sliding_window.hpp"

namespace divemesh::optimisation {
namespace {

using synthetic::IsPoseWithin;
using Way = std::function<Eigen::Isometry3d(double)>;  // T_world_imu at a time in s

constexpr double kNoise_px = 0.2;
const imu::ImuBias kBias{{0.004, -0.006, 0.003}, {0.03, -0.02, 0.04}};
const Eigen::Quaterniond kTilt = base::rotation_from_vector({0.07, -0.09, 0.0});  // 6.5 degrees

// Keyframes at given times, tracked with errors of some millimetres, in a world that is tilted
// against the vertical.
struct Swim {
    Swim(Way the_way, double length_s)
        : way(std::move(the_way)), world(0.3 * length_s, 0.0, 11), window(synthetic::rig(), {}) {
        recording.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 2e-3, 2e-4};
        recording.its_imu = synthetic::imu_along(way, 0.0, length_s, kBias);
    }

    Eigen::Isometry3d truth(double t_s) const {
        return kTilt * way(t_s) * synthetic::rig().T_imu_cam;
    }

    // `first_id` is added to the ids of the features, so that none of them is known if the camera
    // looks elsewhere.
    void add_keyframe(double t_s,
                      std::int64_t first_id = 0,
                      const std::optional<types::MotionSigma>& at_rest = std::nullopt) {
        if (window.empty()) window = SlidingWindow(synthetic::rig(), inertial().noise());
        const auto now_ns = std::llround(1e9 * t_s);
        const std::int64_t before_ns =
            window.empty() ? now_ns : window.keyframes().back().timestamp_ns;
        Eigen::Isometry3d T_world_cam = truth(t_s);
        if (!window.empty()) {
            T_world_cam = window.T_world_cam() *
                          truth(1e-9 * static_cast<double>(before_ns)).inverse() * truth(t_s);
            if (!at_rest)
                T_world_cam.translate(0.004 * Eigen::Vector3d(world.normal(), world.normal(), 0.0));
        }
        types::Features features = world.see(kTilt.conjugate() * truth(t_s), 0, kNoise_px);
        for (types::Feature& feature : features) feature.id += first_id;
        imu::InertialPrior sensors = inertial();
        if (!window.empty()) sensors.set_bias(window.state().bias, 1e-3);
        window.add_keyframe(
            {0, now_ns, T_world_cam}, features, sensors.readings(before_ns, now_ns), at_rest);
        window.adjust();
    }

    imu::InertialPrior inertial() const { return {recording, {}}; }
    double tilt_error_deg() const {
        const double cosine =
            window.reference().gravity_direction_world.dot(kTilt * -Eigen::Vector3d::UnitZ());
        return std::acos(std::min(1.0, cosine)) * 180.0 / std::numbers::pi;
    }

    Way way;
    synthetic::World world;
    synthetic::SensorRecording recording;
    SlidingWindow window;
};

// Swims for four seconds, slows down within one second, and stands still.
Eigen::Isometry3d swim_and_stand(double t_s) {
    const double braking_s = std::clamp(t_s - 4.0, 0.0, 1.0);
    return synthetic::T_world_imu_at(std::min(t_s, 4.0) + braking_s - 0.5 * braking_s * braking_s);
}

TEST(InertialSlidingWindowTest, FindsTheVerticalTheVelocityAndTheBiasesOnTheWay) {
    Swim swim(synthetic::T_world_imu_at, 10.0);
    for (int k = 0; k <= 24; ++k) swim.add_keyframe(0.4 * k);

    EXPECT_LT(swim.tilt_error_deg(), 0.5);
    const Eigen::Vector3d velocity = kTilt * synthetic::velocity(swim.way, 9.6);
    EXPECT_LT((swim.window.state().velocity_world - velocity).norm(), 0.01);
    EXPECT_LT((swim.window.state().bias.gyroscope - kBias.gyroscope).norm(), 1e-3);
    EXPECT_THAT(swim.window.T_world_cam(), IsPoseWithin(swim.truth(9.6), 0.2, 0.012));
}

TEST(InertialSlidingWindowTest, CarriesOnBehindAGapInTheSamples) {
    Swim swim(synthetic::T_world_imu_at, 10.0);
    std::erase_if(swim.recording.its_imu, [](const types::ImuSample& sample) {
        return sample.timestamp_ns > 5'000'000'000 && sample.timestamp_ns < 5'300'000'000;
    });
    for (int k = 0; k <= 24; ++k) swim.add_keyframe(0.4 * k);

    EXPECT_LT(swim.tilt_error_deg(), 0.5);
    EXPECT_THAT(swim.window.T_world_cam(), IsPoseWithin(swim.truth(9.6), 0.2, 0.012));
}

TEST(InertialSlidingWindowTest, DoesNotDriftWhileItStands) {
    Swim swim(swim_and_stand, 26.0);
    for (int k = 0; k <= 12; ++k) swim.add_keyframe(0.4 * k);
    swim.add_keyframe(5.2);
    const Eigen::Isometry3d T_arrived = swim.window.T_world_cam();
    for (int k = 6; k <= 25; ++k) swim.add_keyframe(k);

    EXPECT_THAT(swim.window.T_world_cam(), IsPoseWithin(T_arrived, 0.1, 0.003));
    EXPECT_LT(swim.window.state().velocity_world.norm(), 0.005);
    EXPECT_LT(swim.tilt_error_deg(), 0.7);
}

TEST(InertialSlidingWindowTest, DoesNotRunAwayWhenAllFeaturesChangeWhileItStands) {
    Swim swim(swim_and_stand, 12.0);
    for (int k = 0; k <= 12; ++k) swim.add_keyframe(0.4 * k);
    swim.add_keyframe(5.2);
    const Eigen::Isometry3d T_arrived = swim.window.T_world_cam();
    swim.add_keyframe(6.0, 100'000);
    swim.add_keyframe(6.4, 100'000);

    EXPECT_THAT(swim.window.T_world_cam(), IsPoseWithin(T_arrived, 0.3, 0.02));
}

TEST(InertialSlidingWindowTest, ARestHoldsKeyframesTogetherThatShareNoFeature) {
    Swim swim(swim_and_stand, 42.0);
    for (int k = 0; k <= 12; ++k) swim.add_keyframe(0.4 * k);
    swim.add_keyframe(6.0);
    const Eigen::Isometry3d T_arrived = swim.window.T_world_cam();
    swim.window.set_at_rest();
    for (int k = 1; k <= 5; ++k) {  // readings of more than eight seconds are not integrated
        swim.add_keyframe(6.0 + 7.0 * k, 100'000 * k, types::MotionSigma{0.001, 0.0005});
        swim.window.set_at_rest();
    }

    EXPECT_THAT(swim.window.T_world_cam(), IsPoseWithin(T_arrived, 0.1, 0.004));
    EXPECT_LT(swim.window.state().velocity_world.norm(), 0.02);
}

}  // namespace
}  // namespace divemesh::optimisation
