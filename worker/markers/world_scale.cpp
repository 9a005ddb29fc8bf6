#include "worker/markers/world_scale.hpp"

namespace divemesh::worker {

Eigen::Isometry3d WorldScale::scaled(const Eigen::Isometry3d& T_world_cam,
                                     const Eigen::Vector3d& center_world) const {
    Eigen::Isometry3d result = T_world_cam;
    result.translation() = center_world + factor_ * (T_world_cam.translation() - center_world);
    return result;
}

Eigen::Vector3d WorldScale::center_of(const Trajectory& trajectory) const {
    if (trajectory.empty()) return Eigen::Vector3d::Zero();
    return (trajectory.front().T_world_imu * T_imu_cam_).translation();
}

Trajectory WorldScale::applied(const Trajectory& trajectory) const {
    const Eigen::Vector3d center_world = center_of(trajectory);
    const Eigen::Isometry3d T_cam_imu = T_imu_cam_.inverse();
    Trajectory result = trajectory;
    for (StampedPose& pose : result)
        pose.T_world_imu = scaled(pose.T_world_imu * T_imu_cam_, center_world) * T_cam_imu;
    return result;
}

std::vector<Keyframe> WorldScale::applied(const std::vector<Keyframe>& keyframes,
                                          const Trajectory& trajectory) const {
    const Eigen::Vector3d center_world = center_of(trajectory);
    std::vector<Keyframe> result = keyframes;
    for (Keyframe& keyframe : result)
        keyframe.T_world_cam = scaled(keyframe.T_world_cam, center_world);
    return result;
}

CovarianceTrack WorldScale::applied(const CovarianceTrack& covariances) const {
    CovarianceTrack result = covariances;
    for (PoseCovariance& covariance : result) covariance.position_m2 *= factor_ * factor_;
    return result;
}

Rig WorldScale::applied(const Rig& rig) const {
    Rig result = rig;
    result.T_imu_cam1.translation() =
        rig.T_imu_cam0.translation() +
        factor_ * (rig.T_imu_cam1.translation() - rig.T_imu_cam0.translation());
    return result;
}

Rig rig_as_scaled(const Rig& stated, const nlohmann::json& metrics) {
    const nlohmann::json::json_pointer factor("/markers/scale_correction/factor");
    if (!metrics.contains(factor)) return stated;
    return WorldScale(metrics.at(factor).get<double>(), Eigen::Isometry3d::Identity())
        .applied(stated);
}

}  // namespace divemesh::worker
