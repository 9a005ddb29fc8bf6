#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "worker/recording/image_size.hpp"
#include "worker/recording/messages.hpp"

namespace divemesh::recording {

// Both cameras of a pair as ROS describes them.
struct CameraInfos {
    CameraInfo left;
    CameraInfo right;
};

// Returns the calibration of two cameras in KITTI's files: P0 to P3 of odometry's calib.txt, or the
// lines of camera 00 to 03 of raw data's calib_cam_to_cam.txt, whose P_rect is that of rectified
// images, which have the size S_rect, and K and D that of others. The baseline need not be along x:
// cameras 2 and 3 differ in height too. nullopt if a camera is not described there, or not for
// images of this size.
std::optional<CameraInfos> kitti_cameras(std::string_view text,
                                         int left,
                                         int right,
                                         ImageSize size);

}  // namespace divemesh::recording
