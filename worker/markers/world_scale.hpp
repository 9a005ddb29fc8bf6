#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "worker/types/keyframe.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::markers {

// A world made larger by a factor, about its first camera: what cameras see of it stays the same
// with their baseline larger by it. Where the cameras sit on the body does not change, so that the
// body's first pose stays too, and everything else moves as its camera does.
class WorldScale {
public:
    // `T_imu_cam` of the rectified left camera.
    WorldScale(double factor, const Eigen::Isometry3d& T_imu_cam)
        : factor_(factor), T_imu_cam_(T_imu_cam) {}

    types::Trajectory applied(const types::Trajectory& trajectory) const;
    // Of the trajectory's world: with its first camera in the place that it has there.
    std::vector<types::Keyframe> applied(const std::vector<types::Keyframe>& keyframes,
                                         const types::Trajectory& trajectory) const;
    types::CovarianceTrack applied(const types::CovarianceTrack& covariances) const;
    types::Rig applied(const types::Rig& rig) const;  // the right camera farther from the left one

private:
    Eigen::Isometry3d scaled(const Eigen::Isometry3d& T_world_cam,
                             const Eigen::Vector3d& center_world) const;
    Eigen::Vector3d center_of(const types::Trajectory& trajectory) const;

    double factor_;
    Eigen::Isometry3d T_imu_cam_;
};

// The rig that the poses of a reconstruction belong to: as stated, or as correct_scale made it.
// `metrics` is metrics.json.
types::Rig rig_as_scaled(const types::Rig& stated, const nlohmann::json& metrics);

}  // namespace divemesh::markers
