#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/types/rectified_rig.hpp"

namespace divemesh::types {

// A salient point in one rectified pair. Its id stays the same from frame to frame.
struct Feature {
    std::int64_t id = 0;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // in the left image
    double disparity_px = 0.0;                        // <= 0: not found in the right image
    // d disparity / d (u, v), for a new feature on a slanted surface; 0: the surface faces the
    // camera.
    Eigen::Vector2d disparity_slope = Eigen::Vector2d::Zero();
};
using Features = std::vector<Feature>;  // ids ascending

// Standard deviation of a feature's measured u, v and disparity, px.
inline const Eigen::Vector3d kFeatureSigma_px(0.25, 0.25, 0.2);

// Returns true if the feature was found in both images.
inline bool has_depth(const Feature& feature) { return feature.disparity_px > 0.0; }

// Returns (u, v, disparity), what a stereo camera measures of a point.
inline Eigen::Vector3d measurement_px(const Feature& feature) {
    return {feature.pixel.x(), feature.pixel.y(), feature.disparity_px};
}

// Returns the feature's point in the camera frame, m; it must have depth.
inline Eigen::Vector3d point_cam(const RectifiedRig& rig, const Feature& feature) {
    return rig.point_cam(feature.pixel.x(), feature.pixel.y(), rig.depth_m(feature.disparity_px));
}

// Returns the (u, v, disparity) at which a point appears.
inline Eigen::Vector3d project_px(const RectifiedRig& rig, const Eigen::Vector3d& p_cam) {
    const Eigen::Vector2d pixel = rig.pixel(p_cam);
    return {pixel.x(), pixel.y(), rig.disparity_px(p_cam.z())};
}

}  // namespace divemesh::types
