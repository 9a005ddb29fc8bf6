#pragma once

#include <Eigen/Core>

#include "worker/camera/rectified_lens.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::camera {

// The motion of the rectified left camera, in its own axes.
struct CameraMotion {
    Eigen::Vector3d angular_velocity_cam = Eigen::Vector3d::Zero();  // rad/s
    Eigen::Vector3d velocity_cam = Eigen::Vector3d::Zero();          // m/s
};

// A rolling shutter reads the rows of an image one after the other: row v of h at
//
//     t + (v / h - 1/2) readout_time
//
// with t the time of the middle row, in both cameras alike. Over that time a point p of the
// camera's frame moves by dp/dt = -(w x p) - v (Forssen and Ringaby 2010).
class RollingShutter {
public:
    // `left`: the lens by which the left image was rectified.
    RollingShutter(const types::RectifiedRig& rig, const RectifiedLens& left)
        : rig_(rig), left_(left) {}

    // Returns v / h - 1/2 of the row in which a pixel of the rectified left image was recorded.
    double row_share(const Eigen::Vector2d& seen_px) const;
    // Returns d(u, v, disparity)/dt, px/s, of a point; zero if it is not in front of the camera.
    Eigen::Vector3d flow_px_s(const CameraMotion& motion, const Eigen::Vector3d& p_cam) const;
    // Returns d(u, v, disparity)/d(readout time), px/s, of a point seen at a pixel.
    Eigen::Vector3d shift_px_s(const CameraMotion& motion,
                               const Eigen::Vector2d& seen_px,
                               const Eigen::Vector3d& p_cam) const {
        return row_share(seen_px) * flow_px_s(motion, p_cam);
    }

private:
    types::RectifiedRig rig_;
    RectifiedLens left_;
};

}  // namespace divemesh::camera
