#include "worker/pipeline/motion_between_exposures.hpp"

#include "worker/camera/synchronise_pair.hpp"
#include "worker/odometry/frame_features.hpp"

namespace divemesh::pipeline {

std::optional<types::ExposureMotion> motion_between_exposures(
    const types::RectifiedRig& rig,
    const Eigen::Isometry3d& T_current_previous,
    double share,
    const types::Features& features) {
    if (share == 0.0) return std::nullopt;
    const double disparity_px = odometry::median_disparity_px(features);
    if (disparity_px <= 0.0) return std::nullopt;
    return camera::exposure_motion(rig, T_current_previous, share, disparity_px);
}

}  // namespace divemesh::pipeline
