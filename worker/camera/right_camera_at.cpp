#include "worker/camera/right_camera_at.hpp"

#include "worker/camera/rectified_lens.hpp"

namespace divemesh::camera {

MountedCamera right_camera_at(const types::Rig& rig, std::int64_t timestamp_ns) {
    types::CameraTurn last;
    for (const types::CameraTurn& turn : rig.right_turns)
        if (timestamp_ns >= turn.from_ns) last = turn;
    const RectifiedLens turned = turned_lens({.camera = rig.cam1}, last);
    MountedCamera result{turned.camera, rig.T_imu_cam1};
    result.T_imu_cam.linear() *= turned.R_camera_rectified.transpose();
    return result;
}

}  // namespace divemesh::camera
