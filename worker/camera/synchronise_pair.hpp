#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "worker/types/exposure_motion.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::camera {

// Returns the camera's motion between the exposures, given its motion over a share of the time of
// T_current_previous that ends with the left image.
types::ExposureMotion exposure_motion(const types::RectifiedRig& rig,
                                      const Eigen::Isometry3d& T_current_previous,
                                      double share,
                                      double compensated_disparity_px);

// Returns the frame with its right image warped to the time of the left one, as it is if nothing is
// known `between` them. The warp is that of points at one depth; what is left for others is told by
// the frame's `between`.
types::RectifiedFrame synchronise_pair(const types::RectifiedFrame& frame,
                                       const std::optional<types::ExposureMotion>& between);

// Turns disparities that were matched in a synchronised frame into those at the time of its left
// image. Other frames stay.
void correct_disparities(const types::RectifiedFrame& frame, types::DepthMap& depth);

}  // namespace divemesh::camera
