#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "worker/types/camera.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::camera {

// A camera and where it stands on the body.
struct MountedCamera {
    types::Camera camera;
    Eigen::Isometry3d T_imu_cam = Eigen::Isometry3d::Identity();
};

// Returns the right camera as it stands at a time: after the last of the rig's turns before it.
MountedCamera right_camera_at(const types::Rig& rig, std::int64_t timestamp_ns);

}  // namespace divemesh::camera
