#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "worker/types/exposure_motion.hpp"
#include "worker/types/feature.hpp"

namespace divemesh::pipeline {

// Returns the camera's motion between a pair's exposures, which is a share of T_current_previous,
// for points at the median depth of the features; nullopt if the share is 0 or none has depth.
std::optional<types::ExposureMotion> motion_between_exposures(
    const types::RectifiedRig& rig,
    const Eigen::Isometry3d& T_current_previous,
    double share,
    const types::Features& features);

}  // namespace divemesh::pipeline
