#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::loops {

// The keypoints of a frame with depth that are found again over a wide baseline: extrema of the
// scale space, described by histograms of gradients (SIFT, Lowe 2004). They take about as long as
// five frames of tracking, so they are for when tracking fails.
struct SiftKeypoints {
    types::Features points;        // id: index; all have depth
    std::vector<double> sigma_px;  // of a point's position
    Eigen::MatrixXf descriptors;   // a column per point, of unit length
};

// Returns the keypoints of a frame that are found in its right image as well. Descriptors are
// compared by Hellinger's distance (RootSIFT, Arandjelovic and Zisserman 2012).
SiftKeypoints sift_keypoints(const types::RectifiedFrame& frame, int num_disparities_px);

// Returns pairs that are mutual nearest neighbours and clearly nearer than the second. `previous`
// of a pair belongs to a, `current` to b; its id is that of the point of a. With a guess of the
// motion, neighbours are searched for only around where it leads, within an eighth of the width:
// there more of them are distinct.
odometry::PointPairs match_sift(const types::RectifiedRig& rig,
                                const SiftKeypoints& a,
                                const SiftKeypoints& b,
                                const std::optional<Eigen::Isometry3d>& T_b_a = std::nullopt);

}  // namespace divemesh::loops
