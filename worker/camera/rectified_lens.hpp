#pragma once

#include <Eigen/Core>
#include <array>

#include "worker/types/lens_change.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::camera {

// A camera as recorded and where rectification turned it.
struct RectifiedLens {
    types::Camera camera;
    Eigen::Matrix3d R_camera_rectified = Eigen::Matrix3d::Identity();

    // Of a pixel in the rectified picture.
    Eigen::Vector2d recorded_px(const types::RectifiedRig& rig,
                                const Eigen::Vector2d& rectified_px) const;
    Eigen::Vector2d rectified_px(const types::RectifiedRig& rig,
                                 const Eigen::Vector2d& recorded_px) const;
};

// Half of the rotation between the cameras each, then the row axis along the baseline (Bouguet).
std::array<RectifiedLens, 2> rectified_lenses(const types::Rig& rig);  // left, right

// The camera with its calibration changed by this.
types::Camera changed_camera(const types::Camera& camera, const types::LensChange& change);

// d(u, v)/d(change): how far the picture of a ray moves, in the rectified picture as it was made,
// when the camera is not what rectification took it for. Linear in the change.
Eigen::Matrix<double, 2, types::LensChange::kSize> shift_of_change(
    const types::RectifiedRig& rig, const RectifiedLens& lens, const Eigen::Vector2d& rectified_px);

}  // namespace divemesh::camera
