#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "worker/features/described_keypoints.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::loops {

// Returns pairs of keypoints with depth in both keyframes that are mutual nearest neighbours by
// descriptor and clearly nearer than the second (Lowe 2004). `previous` of a pair belongs to a,
// `current` to b.
odometry::PointPairs match_keypoints(const types::RectifiedRig& rig,
                                     const features::DescribedKeypoints& a,
                                     const features::DescribedKeypoints& b);

// Returns T_b_a on which enough matches agree, accurate to some pixels; nullopt: not the same
// place.
std::optional<Eigen::Isometry3d> register_keypoints(const types::RectifiedRig& rig,
                                                    const features::DescribedKeypoints& a,
                                                    const features::DescribedKeypoints& b,
                                                    std::uint64_t seed);

}  // namespace divemesh::loops
