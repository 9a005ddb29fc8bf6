#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "worker/features/described_keypoints.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::loops {

// Points of two views with depth in both that are each other's nearest by descriptor, and clearly
// nearer than the second (Lowe 2004). `previous` of a pair is of view a, `current` of view b.
odometry::PointPairs match_keypoints(const types::RectifiedRig& rig,
                                     const features::DescribedKeypoints& a,
                                     const features::DescribedKeypoints& b);

// T_b_a on which enough of the matches agree, to some pixels. Nothing: not the same place.
std::optional<Eigen::Isometry3d> register_keypoints(const types::RectifiedRig& rig,
                                                    const features::DescribedKeypoints& a,
                                                    const features::DescribedKeypoints& b,
                                                    std::uint64_t seed);

}  // namespace divemesh::loops
