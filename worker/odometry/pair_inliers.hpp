#pragma once

#include <Eigen/Geometry>

#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/rectified_rig.hpp"

// Agreement of pairs with a motion: the error of the moved point's u, v and disparity. An error in
// metres would favour near points.
namespace divemesh::odometry {

// Returns the pairs within the tolerance.
PointPairs find_inliers(const types::RectifiedRig& rig,
                        const PointPairs& pairs,
                        const Eigen::Isometry3d& T_current_previous,
                        double tolerance_px);

// Returns the sum of truncated squares (MSAC): among sets of equal size the tighter one wins.
double msac_cost(const types::RectifiedRig& rig,
                 const PointPairs& pairs,
                 const Eigen::Isometry3d& T_current_previous,
                 double tolerance_px);

}  // namespace divemesh::odometry
