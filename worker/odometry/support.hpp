#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>

#include "worker/odometry/register_points.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Returns the number of cells of the image, of 8 x 6, with the current position of a pair.
std::size_t num_cells(const types::RectifiedRig& rig, const PointPairs& pairs);

// Returns true if the pairs are, in the median, within 4 px of where a motion predicts them; in
// images of more than 640 px of width within as much of their width.
bool is_near_prediction(const types::RectifiedRig& rig,
                        const PointPairs& pairs,
                        const Eigen::Isometry3d& expected);

// Returns true if a motion that was found by tracking needs no confirmation. Most pairs must agree
// on it, spread over the image. `num_previous` is the number of features with depth in the previous
// frame.
//
// If the motion is within some pixels of the prediction `expected`, ten inliers that are at least
// 5 % of those features are enough. Otherwise, or without a prediction, it needs twenty inliers
// that are at least 40 % of them: where the texture repeats, many features that moved farther may
// be mistaken for their neighbours in the same way.
bool well_supported(const types::RectifiedRig& rig,
                    const Registration& motion,
                    std::size_t num_previous,
                    const std::optional<Eigen::Isometry3d>& expected);

// Returns true if a motion can be the result of chance. That is so if only a tiny share of the
// `num_previous` features agree on it. A motion that differs from the prediction can also be chance
// if few pairs agree on it, or a small share of the pairs or of the features.
bool explained_by_chance(const types::RectifiedRig& rig,
                         const Registration& motion,
                         std::size_t num_previous,
                         const std::optional<Eigen::Isometry3d>& expected);

}  // namespace divemesh::odometry
