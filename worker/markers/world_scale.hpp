#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "worker/types/keyframe.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::markers {

// Scales a world by a factor about its first camera: the cameras' images stay the same if their
// baseline is scaled too. The cameras' poses on the body do not change, so the first pose of the
// body stays as well, and everything else moves with its camera.
class WorldScale {
public:
    // `T_imu_cam` is the pose of the rectified left camera.
    WorldScale(double factor, const Eigen::Isometry3d& T_imu_cam)
        : factor_(factor), T_imu_cam_(T_imu_cam) {}

    double factor() const { return factor_; }

    types::Trajectory applied(const types::Trajectory& trajectory) const;
    // Returns poses beside the trajectory, scaled with it.
    types::Trajectory applied(const types::Trajectory& beside,
                              const types::Trajectory& trajectory) const;
    // Scales keyframes of the trajectory's world, about the trajectory's first camera.
    std::vector<types::Keyframe> applied(const std::vector<types::Keyframe>& keyframes,
                                         const types::Trajectory& trajectory) const;
    types::CovarianceTrack applied(const types::CovarianceTrack& covariances) const;
    // Moves the right camera away from the left one.
    types::Rig applied(const types::Rig& rig) const;

private:
    Eigen::Isometry3d scaled(const Eigen::Isometry3d& T_world_cam,
                             const Eigen::Vector3d& center_world) const;
    Eigen::Vector3d center_of(const types::Trajectory& trajectory) const;

    double factor_;
    Eigen::Isometry3d T_imu_cam_;
};

// Returns the rig that the poses of a reconstruction belong to: as stated, or as scaled by
// correct_scale. `metrics` is metrics.json.
types::Rig rig_as_scaled(const types::Rig& stated, const nlohmann::json& metrics);

}  // namespace divemesh::markers
