#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>

#include "worker/odometry/register_points.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Returns the number of cells of the image, of 8 x 6, with the current position of a pair.
std::size_t num_cells(const types::RectifiedRig& rig, const PointPairs& pairs);

// Returns true if the pairs are, in the median, within some pixels of where a motion predicts them.
bool is_near_prediction(const types::RectifiedRig& rig,
                        const PointPairs& pairs,
                        const Eigen::Isometry3d& expected);

// Returns true if a motion found by tracking from the prediction `expected` needs no confirmation:
// most pairs agree on it, spread over the image, and they are enough, and no tiny share of the
// `num_previous` features that the previous frame had with depth, if it is the predicted motion
// within some pixels. Another motion, and any if nothing is expected, must hold for a good part of
// those features: features that moved farther may have been taken for their neighbours where the
// texture repeats, all in the same way.
bool well_supported(const types::RectifiedRig& rig,
                    const Registration& motion,
                    std::size_t num_previous,
                    const std::optional<Eigen::Isometry3d>& expected);

// Returns true if chance explains a motion: a tiny share of the `num_previous` features that were
// looked for agree on it, or it is not the predicted one and few pairs, a small share of them or a
// small share of the features do.
bool explained_by_chance(const types::RectifiedRig& rig,
                         const Registration& motion,
                         std::size_t num_previous,
                         const std::optional<Eigen::Isometry3d>& expected);

}  // namespace divemesh::odometry
