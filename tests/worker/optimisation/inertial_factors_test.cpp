#include "worker/optimisation/inertial_factors.hpp"

#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/sensor_recording.hpp"

namespace divemesh::optimisation {
namespace {

constexpr int kNumKeyframes = 20;
constexpr int kStep = 4;  // frames of 0.1 s between keyframes
const imu::ImuBias kBias{{0.004, -0.006, 0.003}, {0.03, -0.02, 0.04}};
const Eigen::Quaterniond kTilt = base::rotation_from_vector({0.07, -0.09, 0.0});  // 6.5 degrees

double seconds(std::int64_t time_ns) { return 1e-9 * static_cast<double>(time_ns); }

// The path of stereo_world.hpp, with keyframes in a world that is tilted against the vertical.
struct TiltedDive {
    synthetic::SensorRecording recording;
    std::vector<types::Keyframe> keyframes;
    std::vector<BodyState> states;
    std::map<std::int64_t, Eigen::Vector3d> landmarks;

    TiltedDive() {
        const double length_s = 0.1 * kStep * kNumKeyframes;
        recording.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 2e-3, 2e-4};
        recording.its_imu = synthetic::imu_along(synthetic::T_world_imu_at, 0.0, length_s, kBias);
        for (int k = 0; k <= kNumKeyframes; ++k) {
            const std::int64_t time_ns = 100'000'000LL * kStep * k;
            const Eigen::Isometry3d T = kTilt * synthetic::T_world_imu_at(seconds(time_ns));
            keyframes.push_back({kStep * k, time_ns, T * synthetic::rig().T_imu_cam});
            states.push_back(BodyState::at(T, {}));
        }
    }

    // Adjusts with the measurements of cameras and sensors.
    WorldReference adjust(const imu::InertialPrior& inertial) {
        BundleAdjustment bundle_adjustment(synthetic::rig());
        see(bundle_adjustment, 0.1);
        return solve(bundle_adjustment, inertial);
    }

    WorldReference solve(BundleAdjustment& bundle_adjustment, const imu::InertialPrior& inertial) {
        WorldReference reference;
        add_inertial_factors(bundle_adjustment, inertial, keyframes, states, reference);
        bundle_adjustment.solve_sparse(15, base::ignore_progress, {});
        return reference;
    }

    void see(BundleAdjustment& bundle_adjustment, double noise_px) {
        const types::RectifiedRig rig = synthetic::rig();
        synthetic::World world(0.03 * kStep * kNumKeyframes, 0.0, 3);
        for (std::size_t k = 0; k < states.size(); ++k) {
            bundle_adjustment.add_state(states[k], k == 0);
            const int frame = kStep * static_cast<int>(k);
            for (const types::Feature& feature :
                 world.see(synthetic::T_world_cam(frame), frame, noise_px)) {
                const auto landmark = landmarks.try_emplace(
                    feature.id, keyframes[k].T_world_cam * types::point_cam(rig, feature));
                bundle_adjustment.add_observation(states[k],
                                                  landmark.first->second,
                                                  types::measurement_px(feature),
                                                  types::kFeatureSigma_px);
            }
        }
    }
};

double tilt_deg(const Eigen::Quaterniond& q) {
    const Eigen::Vector3d up = q * Eigen::Vector3d::UnitZ();
    return std::acos(std::min(1.0, up.z())) * 180.0 / std::numbers::pi;
}

TEST(InertialFactorsTest, FindTheVerticalOfATiltedWorldWithTheVelocitiesAndBiases) {
    TiltedDive dive;
    const imu::InertialPrior inertial(dive.recording, {});
    const WorldReference reference = dive.adjust(inertial);

    EXPECT_GT(tilt_deg(kTilt), 6.0);
    EXPECT_LT(tilt_deg(gravity_alignment(inertial, reference) * kTilt), 0.4);
    const BodyState& state = dive.states[10];
    const Eigen::Vector3d velocity =
        kTilt *
        synthetic::velocity(synthetic::T_world_imu_at, seconds(dive.keyframes[10].timestamp_ns));
    EXPECT_LT((state.velocity_world - velocity).norm(), 0.01);
    EXPECT_LT((state.bias.gyroscope - kBias.gyroscope).norm(), 5e-4);
}

TEST(InertialFactorsTest, CarryOnBehindAGapInTheSamples) {
    TiltedDive dive;
    std::erase_if(dive.recording.its_imu, [](const types::ImuSample& sample) {
        return sample.timestamp_ns > 3'300'000'000 && sample.timestamp_ns < 3'700'000'000;
    });
    const imu::InertialPrior inertial(dive.recording, {});
    const WorldReference reference = dive.adjust(inertial);

    EXPECT_LT(tilt_deg(gravity_alignment(inertial, reference) * kTilt), 0.4);
}

TEST(InertialFactorsTest, AnAhrsAloneLevelsTheWorld) {
    TiltedDive dive;
    dive.recording.its_rig.imu_noise.reset();
    dive.recording.its_imu.clear();
    for (const types::Keyframe& keyframe : dive.keyframes)
        dive.recording.its_ahrs.push_back(
            {keyframe.timestamp_ns,
             Eigen::Quaterniond(
                 synthetic::T_world_imu_at(seconds(keyframe.timestamp_ns)).linear())});
    const imu::InertialPrior inertial(dive.recording, {});
    const WorldReference reference = dive.adjust(inertial);

    EXPECT_LT(tilt_deg(gravity_alignment(inertial, reference) * kTilt), 0.1);
}

TEST(InertialFactorsTest, TakeTheDepthBetweenReadingsButNotAcrossAGap) {
    synthetic::SensorRecording recording;
    recording.its_pressure = {{0, 5.0}, {100'000'000, 6.0}, {2'000'000'000, 9.0}};
    const imu::InertialPrior inertial(recording, {});
    const imu::SensorReadings readings = inertial.readings(0, 25'000'000);

    ASSERT_TRUE(readings.depth_m);
    EXPECT_NEAR(*readings.depth_m, 5.25, 1e-12);
    EXPECT_FALSE(readings.motion || readings.rotation || readings.q_ahrs_imu);
    EXPECT_FALSE(inertial.depth_m(1'000'000'000));
    EXPECT_FALSE(inertial.depth_m(2'000'000'001));
}

// The path goes up and down along the wall: the depths show which direction is vertical.
TEST(InertialFactorsTest, ThePressureAloneTellsTheVerticalWhereTheDiverRisesAndSinks) {
    TiltedDive dive;
    BundleAdjustment bundle_adjustment(synthetic::rig());
    for (std::size_t k = 0; k < dive.states.size(); ++k) {
        const auto t = static_cast<double>(k);
        const Eigen::Vector3d p(0.1 * t, 0.3 * std::sin(t), 0.5 * std::sin(0.7 * t));
        dive.states[k].p_world_imu = kTilt * p;
        bundle_adjustment.add_state(dive.states[k], true);
        dive.recording.its_pressure.push_back({dive.keyframes[k].timestamp_ns, 8.0 - p.z()});
    }
    dive.recording.its_rig.imu_noise.reset();
    const imu::InertialPrior inertial(dive.recording, {});
    const WorldReference reference = dive.solve(bundle_adjustment, inertial);

    EXPECT_LT(tilt_deg(gravity_alignment(inertial, reference) * kTilt), 0.5);
    EXPECT_NEAR(reference.depth_offset_m, 8.0, 0.01);
}

// A recorder set to another density: the motion by vision keeps the heights, and its scale shows.
TEST(InertialFactorsTest, DepthsOfAnotherDensityDoNotStretchThePath) {
    constexpr double kScale = 1.03;
    TiltedDive dive;
    dive.recording.its_rig.imu_noise.reset();
    BundleAdjustment bundle_adjustment(synthetic::rig());
    std::vector<Eigen::Vector3d> truth;
    for (std::size_t k = 0; k < dive.states.size(); ++k) {
        const auto t = static_cast<double>(k);
        const Eigen::Vector3d p(0.1 * t, 0.3 * std::sin(t), 1.5 * std::sin(0.7 * t));
        dive.states[k] = BodyState::at(Eigen::Isometry3d(Eigen::Translation3d(p)), {});
        truth.push_back(p);
        bundle_adjustment.add_state(dive.states[k], k == 0);
        dive.recording.its_pressure.push_back(
            {dive.keyframes[k].timestamp_ns, 8.0 - kScale * p.z()});
    }
    for (std::size_t k = 1; k < truth.size(); ++k)
        bundle_adjustment.add_motion(
            dive.states[k - 1],
            dive.states[k],
            Eigen::Isometry3d(Eigen::Translation3d(truth[k] - truth[k - 1])),
            0.001,
            0.0005);
    const WorldReference reference =
        dive.solve(bundle_adjustment, imu::InertialPrior(dive.recording, {}));
    double worst_m = 0.0;
    for (std::size_t k = 0; k < truth.size(); ++k)
        worst_m = std::max(worst_m, (dive.states[k].p_world_imu - truth[k]).norm());
    EXPECT_NEAR(reference.depth_scale, kScale, 0.003);
    EXPECT_LT(worst_m, 0.001);
}

TEST(InertialFactorsTest, DepthsThatErrForSecondsWeighLess) {
    TiltedDive dive;
    dive.recording.its_pressure = {{0, 5.0}, {1'000'000'000, 5.0}};
    imu::InertialPrior inertial(dive.recording, {});
    EXPECT_EQ(inertial.readings(0, 500'000'000).depth_sigma_m, imu::kUsualDepthSigma_m);
    inertial.set_pressure_error(0.02);
    EXPECT_EQ(inertial.readings(0, 500'000'000).depth_sigma_m, imu::kUsualDepthSigma_m);
    inertial.set_pressure_error(0.2);
    EXPECT_NEAR(inertial.readings(0, 500'000'000).depth_sigma_m, 0.45, 0.01);
}

}  // namespace
}  // namespace divemesh::optimisation
