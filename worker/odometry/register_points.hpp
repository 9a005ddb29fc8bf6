#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

struct Registration {
    bool found = false;       // enough pairs agree, and they determine it
    bool degenerate = false;  // enough agree, but they do not
    Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();
    double scale = 1.0;  // Horn's s over the inliers: reported, never applied
    PointPairs inliers;
    std::size_t num_pairs = 0;
};

inline constexpr std::size_t kMinInliers = 8;
// A pair agrees with a motion within this.
inline constexpr double kInlierTolerance_px = 2.0;

// Step 4: RANSAC over Horn's absolute orientation, three pairs a try: vision alone, and whatever
// moves by itself (fish, snow) left out. A pair agrees when the moved point projects to within
// `tolerance_px` of where it was seen, disparity included: metres would favour what is near. The
// same pairs and seed give the same result.
Registration register_points(const types::RectifiedRig& rig,
                             const PointPairs& pairs,
                             double tolerance_px,
                             std::uint64_t seed);

}  // namespace divemesh::odometry
