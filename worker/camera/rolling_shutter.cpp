#include "worker/camera/rolling_shutter.hpp"

namespace divemesh::camera {
namespace {

constexpr double kMinDepth_m = 0.02;

}  // namespace

double RollingShutter::row_share(const Eigen::Vector2d& seen_px) const {
    return left_.recorded_px(rig_, seen_px).y() / left_.camera.height_px - 0.5;
}

Eigen::Vector3d RollingShutter::flow_px_s(const CameraMotion& motion,
                                          const Eigen::Vector3d& p_cam) const {
    if (!(p_cam.z() > kMinDepth_m)) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d p_cam_per_s =
        -motion.angular_velocity_cam.cross(p_cam) - motion.velocity_cam;
    const double approach_per_s = p_cam_per_s.z() / p_cam.z();
    return rig_.focal_px / p_cam.z() *
           Eigen::Vector3d(p_cam_per_s.x() - approach_per_s * p_cam.x(),
                           p_cam_per_s.y() - approach_per_s * p_cam.y(),
                           -approach_per_s * rig_.baseline_m);
}

}  // namespace divemesh::camera
