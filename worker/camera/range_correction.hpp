#pragma once

#include <memory>

#include "worker/types/keyframe.hpp"
#include "worker/types/range_table.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::camera {

// Returns the correction by range for the pairs of a rig behind ports, rectified to `rectified`.
// For each node the left pixel is traced along its refracted ray to where the right camera shows it
// with the measured disparity; an ideal pair shows the point there as the table says. nullptr for a
// rig without ports. `num_threads`: 0: all cores.
std::shared_ptr<const types::RangeTable> range_table(const types::Rig& rig,
                                                     const types::RectifiedRig& rectified,
                                                     int num_threads = 0);

// Returns (u, v, disparity) of an ideal pair for a pixel of the rectified left image and its
// disparity, which is that of an ideal pair already (RectifiedFrame::disparity_px()).
Eigen::Vector3d at_own_range(const types::RangeTable& table, const Eigen::Vector3d& measured_px);

// Returns image and depth resampled to where an ideal pair shows them, as at_own_range() does. A
// pixel without disparity moves as one with the mean of the others.
types::KeyframeImages at_own_range(const types::RangeTable& table,
                                   const types::KeyframeImages& images);

}  // namespace divemesh::camera
