#include "worker/camera/right_camera_at.hpp"

#include "worker/base/rotation_vector.hpp"

namespace divemesh::camera {

MountedCamera right_camera_at(const types::Rig& rig, std::int64_t timestamp_ns) {
    types::CameraTurn last;
    for (const types::CameraTurn& turn : rig.right_turns)
        if (timestamp_ns >= turn.from_ns) last = turn;
    MountedCamera result{rig.cam1, rig.T_imu_cam1};
    result.T_imu_cam.rotate(base::rotation_from_vector(last.rotation));
    result.camera.fx_px *= 1.0 + last.focal;
    result.camera.fy_px *= 1.0 + last.focal;
    return result;
}

}  // namespace divemesh::camera
