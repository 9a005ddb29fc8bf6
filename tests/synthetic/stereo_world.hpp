#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

#include "tests/synthetic/ideal_rig.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/feature.hpp"

namespace divemesh::synthetic {

// Returns a rig of 640x480 px whose camera is 8 cm from the IMU and rotated by about 90 degrees.
inline types::RectifiedRig rig() {
    types::RectifiedRig rig = ideal_rig(640, 480, 500.0);
    rig.T_imu_cam.linear() = base::rotation_from_vector({0.02, -0.03, 1.56}).toRotationMatrix();
    rig.T_imu_cam.translation() = Eigen::Vector3d(-0.03, -0.06, 0.04);
    return rig;
}

// Returns the pose on a diver's path along a wall: 3 cm per frame, with roll, pitch, yaw and heave.
inline Eigen::Isometry3d T_world_cam(double frame) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() << 0.03 * frame, 0.05 * std::sin(0.05 * frame), 0.04 * std::sin(0.04 * frame);
    T.linear() = base::rotation_from_vector({0.05 * std::sin(0.06 * frame),
                                             0.06 * std::sin(0.05 * frame),
                                             0.04 * std::sin(0.03 * frame)})
                     .toRotationMatrix();
    return T;
}

// A rough wall 2 m in front of the path, and fish, whose points each move with a velocity of their
// own.
class World {
public:
    World(double length_m, double fish_share, std::uint32_t seed) : random_(seed) {
        const int num = static_cast<int>(90.0 * (length_m + 3.0));
        for (int i = 0; i < num; ++i) {
            points_.emplace_back(
                uniform(-1.5, length_m + 1.5), uniform(-1.2, 1.2), 2.0 + 0.25 * normal());
            const bool fish = uniform(0.0, 1.0) < fish_share;
            velocity_.push_back(
                fish ? Eigen::Vector3d(0.03 * normal(), 0.03 * normal(), 0.03 * normal())
                     : Eigen::Vector3d::Zero());
        }
    }

    // Returns the features of a frame, with noise of `noise_px` on u, v and disparity.
    types::Features see(const Eigen::Isometry3d& T_world_camera, int frame, double noise_px) {
        types::Features features;
        for (std::size_t i = 0; i < points_.size(); ++i) {
            const Eigen::Vector3d p_cam =
                T_world_camera.inverse() * (points_[i] + frame * velocity_[i]);
            if (p_cam.z() < 0.3) continue;
            const Eigen::Vector3d m = types::project_px(rig(), p_cam) +
                                      noise_px * Eigen::Vector3d(normal(), normal(), normal());
            if (m.x() < m.z() || m.y() < 0.0 || m.x() > 639.0 || m.y() > 479.0) continue;
            features.push_back({static_cast<std::int64_t>(i), m.head<2>(), m.z()});
        }
        return features;
    }
    bool is_fish(std::int64_t id) const {
        return !velocity_[static_cast<std::size_t>(id)].isZero();
    }

    double normal() { return normal_(random_); }
    double uniform(double from, double to) {
        return std::uniform_real_distribution<double>(from, to)(random_);
    }

private:
    std::mt19937 random_;
    std::normal_distribution<double> normal_;
    std::vector<Eigen::Vector3d> points_;
    std::vector<Eigen::Vector3d> velocity_;  // m per frame
};

}  // namespace divemesh::synthetic
