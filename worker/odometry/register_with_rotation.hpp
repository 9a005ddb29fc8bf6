#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Step 4 with the turn known by the gyroscope: one pair gives the translation, so that few tries
// find the motion among many outliers, on planes too. `expected` (T_current_previous) is tried
// first. Where the turn is unknown, or fewer than most pairs agree with it, the paper's Horn is
// asked as well and the better of the two taken. The motion given back is refined over the
// inliers by vision alone. Inliers that, with the turn where it is known, leave some part of the
// motion open are degenerate: nothing is found.
Registration register_with_rotation(const types::RectifiedRig& rig,
                                    const PointPairs& pairs,
                                    const std::optional<types::KnownRotation>& rotation,
                                    const Eigen::Isometry3d& expected,
                                    double tolerance_px,
                                    std::uint64_t seed);

}  // namespace divemesh::odometry
