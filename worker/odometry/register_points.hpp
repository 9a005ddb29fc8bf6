#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// The motion from vision, with its inliers.
struct Registration {
    bool found = false;       // enough pairs agree, and they determine the motion
    bool degenerate = false;  // enough agree, but do not determine the motion
    Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();
    double scale = 1.0;  // Horn's s over the inliers: reported, never applied
    PointPairs inliers;
    std::size_t num_pairs = 0;
};

inline constexpr std::size_t kMinInliers = 8;
// Max error of a pair that agrees with a motion.
inline constexpr double kInlierTolerance_px = 2.0;

// Step 4: RANSAC over Horn's absolute orientation with three pairs per iteration: vision alone, and
// dynamic features (fish, marine snow) are outliers. A pair agrees if the moved point projects to
// within `tolerance_px` of its measurement, disparity included; an error in metres would favour
// near points. The result depends only on the pairs and the seed.
Registration register_points(const types::RectifiedRig& rig,
                             const PointPairs& pairs,
                             double tolerance_px,
                             std::uint64_t seed);

}  // namespace divemesh::odometry
