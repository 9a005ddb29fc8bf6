#pragma once

#include <Eigen/Geometry>
#include <span>

#include "worker/fusion/depth_view.hpp"

namespace divemesh::fusion {

// Marks the pixels of a view whose surface none of the other frames has where it can measure depth:
// at the borders of a dive, and between stills that overlap little. No other frame can confirm
// or refute a depth there, so it may be surface by itself. `T_other_cam` maps the view's camera to
// the cameras of the frames around it; all have the same rig.
void mark_unshared(std::span<const Eigen::Isometry3d> T_other_cam, DepthView& view);

}  // namespace divemesh::fusion
