#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "worker/types/exposure_motion.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::camera {

// Returns the camera's motion from the exposure of the left image to that of the right one, which
// takes a share of the time of T_current_previous; negative: the right image is the earlier one.
types::ExposureMotion exposure_motion(const types::RectifiedRig& rig,
                                      const Eigen::Isometry3d& T_current_previous,
                                      double share,
                                      double compensated_disparity_px);

// Returns the frame with its right image warped to the time of the left one; the frame unchanged if
// `between` is nullopt. The warp is exact for points at one depth. The frame's `between` holds the
// correction for other depths.
types::RectifiedFrame synchronise_pair(const types::RectifiedFrame& frame,
                                       const std::optional<types::ExposureMotion>& between);

// Turns disparities as they were matched into those of an ideal pair at the time of the left image
// (RectifiedFrame::disparity_px()).
void correct_disparities(const types::RectifiedFrame& frame, types::DepthMap& depth);

}  // namespace divemesh::camera
