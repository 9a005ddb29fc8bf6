#include "worker/odometry/imu_aligner.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "tests/synthetic/stereo_world.hpp"
#include "worker/base/seconds.hpp"
#include "worker/odometry/motion_by_vision.hpp"

namespace divemesh::odometry {
namespace {

constexpr int kNumFrames = 100;

// Four times as fast as the path of stereo_world.hpp, so that its rotations show a misalignment.
Eigen::Isometry3d T_world_cam_at(double t_s) { return synthetic::T_world_cam(40.0 * t_s); }

Eigen::Isometry3d T_world_imu_at(double t_s) {
    return T_world_cam_at(t_s) * synthetic::rig().T_imu_cam.inverse();
}

// Returns the alignment found in a dive whose IMU is mounted as calibrated. `landmark_error`: the
// landmarks used by the registration are rotated by this fraction of each rotation, about these
// axes of the camera.
types::ImuAlignment alignment_found(const Eigen::Vector3d& landmark_error) {
    const types::RectifiedRig rig = synthetic::rig();
    synthetic::SensorRecording recording;
    recording.its_rig.imu_noise = types::ImuNoise{};
    recording.its_imu = synthetic::imu_along(T_world_imu_at, -0.5, 11.0, {});
    imu::InertialPrior inertial(recording, preset_options("standard"));
    ImuAligner aligner(recording);
    synthetic::World world(14.0, 0.0, 3);
    types::Features before = world.see(T_world_cam_at(0.0), 0, 0.1);
    for (int k = 1; k <= kNumFrames; ++k) {
        const types::Features now = world.see(T_world_cam_at(0.1 * k), k, 0.1);
        const PointPairs measured = with_depth_at_both_times(rig, before, now);
        Registration vision;
        vision.found = true;
        vision.T_current_previous =
            T_world_cam_at(0.1 * k).inverse() * T_world_cam_at(0.1 * (k - 1));
        vision.inliers = measured;
        const Eigen::Vector3d rotation =
            base::vector_from_rotation(Eigen::Quaterniond(vision.T_current_previous.linear()));
        const Eigen::Quaterniond askew = base::rotation_from_vector(landmark_error.cross(rotation));
        for (PointPair& pair : vision.inliers) {
            pair.p_previous = askew * pair.p_previous;
            pair.previous_px = types::project_px(rig, pair.p_previous);
        }
        const auto motion = motion_by_vision(rig,
                                             measured,
                                             vision,
                                             std::int64_t{100'000'000} * (k - 1),
                                             std::int64_t{100'000'000} * k);
        if (motion) aligner.watch(*motion, inertial);
        before = now;
    }
    return aligner.alignment();
}

TEST(ImuAlignerTest, AUnitThatSitsAsCalibratedIsLeftAlone) {
    const types::ImuAlignment found = alignment_found({0.0, 0.0, 0.0});
    EXPECT_EQ(found.time_offset_s, 0.0);
    EXPECT_EQ(found.q_body_imu.angularDistance(Eigen::Quaterniond::Identity()), 0.0);
}

TEST(ImuAlignerTest, LandmarksThatAMisalignedUnitHasPlacedDoNotConfirmIt) {
    const types::ImuAlignment found = alignment_found({0.05, 0.05, -0.05});
    EXPECT_EQ(found.time_offset_s, 0.0);
    EXPECT_EQ(found.q_body_imu.angularDistance(Eigen::Quaterniond::Identity()), 0.0);
}

// What vision measures in the first two seconds comes 15 ms late, as when a fish fills the images
// of a rig that hardly turns; later rotations are right. Tracking starts again with each offset
// that it learns.
TEST(ImuAlignerTest, TheFirstSecondsDoNotOverturnWhatMoreRotationsTold) {
    constexpr double kStep_s = 0.05, kLate_s = 0.015;
    constexpr int kNum = 200, kNumLate = 40;
    synthetic::SensorRecording recording;
    recording.its_rig.imu_noise = types::ImuNoise{};
    recording.its_imu = synthetic::imu_along(T_world_imu_at, -0.5, 11.0, {});
    const auto motion = [&](int k) -> imu::VisionMotion {
        const double late_s = k < kNumLate ? kLate_s : 0.0;
        return {base::to_ns(kStep_s * k),
                base::to_ns(kStep_s * (k + 1)),
                T_world_imu_at(kStep_s * k - late_s).inverse() *
                    T_world_imu_at(kStep_s * (k + 1) - late_s)};
    };
    types::ImuAlignment start;
    std::size_t num_known = 0;
    std::vector<double> learnt_s;
    for (bool is_done = false; !is_done && learnt_s.size() < 6;) {
        is_done = true;
        imu::InertialPrior inertial(recording, preset_options("standard"));
        ImuAligner aligner(recording, {}, start, num_known);
        for (int k = 0; k < kNum && is_done; ++k) {
            aligner.watch(motion(k), inertial);
            is_done = std::abs(aligner.alignment().time_offset_s - start.time_offset_s) < 0.01;
        }
        if (is_done) break;
        start = aligner.alignment();
        num_known = aligner.num_rotations();
        learnt_s.push_back(start.time_offset_s);
    }
    ASSERT_EQ(learnt_s.size(), 2U) << "once wrong, then right";
    EXPECT_NEAR(learnt_s[0], -kLate_s, 0.003);
    EXPECT_NEAR(learnt_s[1], 0.0, 0.005);
}

}  // namespace
}  // namespace divemesh::odometry
