#pragma once

#include <cstdint>
#include <optional>

#include "worker/imu/estimate_alignment.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Returns the body's motion by the inliers of `vision` among `measured`, pairs as measured by the
// two frames alone, to compare the inertial sensors with. (Landmarks would not do: the sliding
// window places them with the same sensors, so their error would confirm itself.) nullopt if vision
// found no motion or has fewer than 30 inliers.
std::optional<imu::VisionMotion> motion_by_vision(const types::RectifiedRig& rig,
                                                  const PointPairs& measured,
                                                  const Registration& vision,
                                                  std::int64_t before_ns,
                                                  std::int64_t now_ns);

}  // namespace divemesh::odometry
