#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "worker/imu/inertial_prior.hpp"
#include "worker/odometry/predict_orientation.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// The camera's pose and motion. It predicts a frame before its features are tracked, and continues
// when vision fails.
class MotionModel {
public:
    MotionModel(const types::RectifiedRig& rig, const imu::InertialPrior& inertial)
        : rig_(rig), inertial_(inertial) {}

    void start(std::int64_t timestamp_ns, const Eigen::Isometry3d& T_world_cam);
    // Returns the camera's rotation by the inertial sensors since the last frame; nullopt if
    // unknown.
    std::optional<types::KnownRotation> rotation(std::int64_t timestamp_ns) const;
    // Returns the predicted T_current_previous. If velocity and vertical are known, the IMU
    // predicts it. Otherwise the velocity is taken as constant, and the rotation is that of the
    // inertial sensors if it is known. From two seconds after vision was lost, the predicted
    // translation is zero.
    Eigen::Isometry3d predict(const std::optional<types::KnownRotation>& rotation,
                              std::int64_t timestamp_ns) const;
    // Returns T_current_previous if the rig moves and turns on as before.
    Eigen::Isometry3d predict_steadily(std::int64_t timestamp_ns) const {
        return steady_motion(timestamp_ns).inverse();
    }
    // Returns the time since the velocity was known, s, if predict() is the IMU's motion from it.
    std::optional<double> imu_alone_s(std::int64_t timestamp_ns) const;
    // Returns true if predict() is right to some pixels: by the IMU, or because too little time has
    // passed for another motion.
    bool predicts_reliably(std::int64_t timestamp_ns) const;
    void advance(const Eigen::Isometry3d& T_current_previous, std::int64_t timestamp_ns);
    // Records that vision measured the motion to the last pose.
    void confirm_by_vision() { seen_ns_ = timestamp_ns_; }
    // Corrects the last pose, and with an IMU the velocity and the vertical.
    void correct(const Eigen::Isometry3d& T_world_cam) { T_world_cam_ = T_world_cam; }
    void correct(const Eigen::Vector3d& velocity_world,
                 const Eigen::Vector3d& gravity_direction_world) {
        inertial_state_ = InertialState{velocity_world, gravity_direction_world, timestamp_ns_};
    }

    // Records that the rig rests at the last pose.
    void rest();

    // Returns true if vision has not measured the last motions, for longer than the IMU can carry.
    bool is_lost(std::int64_t timestamp_ns) const;

    bool started() const { return started_; }
    const Eigen::Isometry3d& T_world_cam() const { return T_world_cam_; }
    std::int64_t timestamp_ns() const { return timestamp_ns_; }

private:
    // Both return T_previous_current.
    Eigen::Isometry3d predict_by_imu(const imu::PreintegratedImu& motion) const;
    Eigen::Isometry3d steady_motion(std::int64_t timestamp_ns) const;

    // The state that the IMU needs to predict the motion of the body.
    struct InertialState {
        Eigen::Vector3d velocity_world;
        Eigen::Vector3d gravity_direction_world;
        std::int64_t known_ns;
    };

    types::RectifiedRig rig_;
    const imu::InertialPrior& inertial_;
    std::optional<InertialState> inertial_state_;
    bool started_ = false;
    std::int64_t timestamp_ns_ = 0;
    std::int64_t seen_ns_ = 0;  // when vision last measured a motion
    Eigen::Isometry3d T_world_cam_ = Eigen::Isometry3d::Identity();
    Eigen::Vector3d velocity_cam_ = Eigen::Vector3d::Zero();          // m/s
    Eigen::Vector3d angular_velocity_cam_ = Eigen::Vector3d::Zero();  // rad/s
};

}  // namespace divemesh::odometry
