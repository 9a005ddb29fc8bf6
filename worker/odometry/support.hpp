#pragma once

#include <cstddef>

#include "worker/odometry/register_points.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Returns the number of cells of the image, of 8 x 6, with the current position of a pair.
std::size_t num_cells(const types::RectifiedRig& rig, const PointPairs& pairs);

// Returns true if a motion has so many inliers, so large a share of the features that the previous
// frame had with depth (`num_previous`), and so wide a spread over the image that chance does not
// explain it.
bool well_supported(const types::RectifiedRig& rig,
                    const Registration& motion,
                    std::size_t num_previous);

}  // namespace divemesh::odometry
