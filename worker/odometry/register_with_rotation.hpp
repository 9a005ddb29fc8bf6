#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Step 4 with the rotation known from the gyroscope: one pair gives the translation, so that few
// iterations find the motion among many outliers, on planes too. `expected` (T_current_previous) is
// tried first. If the rotation is unknown, or too few pairs agree with it, register_points runs as
// well, and without a rotation `expected`, and the best result is taken. The returned motion is
// refined over the inliers by vision alone. If the inliers and the known rotation leave a part of
// the motion undetermined, the result is degenerate and not `found`.
Registration register_with_rotation(const types::RectifiedRig& rig,
                                    const PointPairs& pairs,
                                    const std::optional<types::KnownRotation>& rotation,
                                    const Eigen::Isometry3d& expected,
                                    double tolerance_px,
                                    std::uint64_t seed);

// Returns the motion near the expected one on which pairs agree. More pairs may agree on another
// motion.
Registration register_near(const types::RectifiedRig& rig,
                           const PointPairs& pairs,
                           const std::optional<types::KnownRotation>& rotation,
                           const Eigen::Isometry3d& expected,
                           double tolerance_px);

}  // namespace divemesh::odometry
