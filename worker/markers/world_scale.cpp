#include "worker/markers/world_scale.hpp"

namespace divemesh::markers {

Eigen::Isometry3d WorldScale::scaled(const Eigen::Isometry3d& T_world_cam,
                                     const Eigen::Vector3d& center_world) const {
    Eigen::Isometry3d result = T_world_cam;
    result.translation() = center_world + factor_ * (T_world_cam.translation() - center_world);
    return result;
}

Eigen::Vector3d WorldScale::center_of(const types::Trajectory& trajectory) const {
    if (trajectory.empty()) return Eigen::Vector3d::Zero();
    return (trajectory.front().T_world_imu * T_imu_cam_).translation();
}

types::Trajectory WorldScale::applied(const types::Trajectory& trajectory) const {
    return applied(trajectory, trajectory);
}

types::Trajectory WorldScale::applied(const types::Trajectory& beside,
                                      const types::Trajectory& trajectory) const {
    const Eigen::Vector3d center_world = center_of(trajectory);
    const Eigen::Isometry3d T_cam_imu = T_imu_cam_.inverse();
    types::Trajectory result = beside;
    for (types::StampedPose& pose : result)
        pose.T_world_imu = scaled(pose.T_world_imu * T_imu_cam_, center_world) * T_cam_imu;
    return result;
}

std::vector<types::Keyframe> WorldScale::applied(const std::vector<types::Keyframe>& keyframes,
                                                 const types::Trajectory& trajectory) const {
    const Eigen::Vector3d center_world = center_of(trajectory);
    std::vector<types::Keyframe> result = keyframes;
    for (types::Keyframe& keyframe : result)
        keyframe.T_world_cam = scaled(keyframe.T_world_cam, center_world);
    return result;
}

types::CovarianceTrack WorldScale::applied(const types::CovarianceTrack& covariances) const {
    types::CovarianceTrack result = covariances;
    for (types::PoseCovariance& covariance : result) covariance.position_m2 *= factor_ * factor_;
    return result;
}

types::Rig WorldScale::applied(const types::Rig& rig) const {
    types::Rig result = rig;
    result.T_imu_cam1.translation() =
        rig.T_imu_cam0.translation() +
        factor_ * (rig.T_imu_cam1.translation() - rig.T_imu_cam0.translation());
    return result;
}

types::Rig rig_as_scaled(const types::Rig& stated, const nlohmann::json& metrics) {
    for (const char* place :
         {"/markers/scale_correction/factor", "/calibration/scale_correction/factor"}) {
        const nlohmann::json::json_pointer factor(place);
        if (!metrics.contains(factor)) continue;
        return WorldScale(metrics.at(factor).get<double>(), Eigen::Isometry3d::Identity())
            .applied(stated);
    }
    return stated;
}

}  // namespace divemesh::markers
