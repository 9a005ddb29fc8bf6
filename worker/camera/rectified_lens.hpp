#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>

#include "worker/types/lens_change.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::camera {

// A camera as calibrated, with the rotation that rectification applies to it.
struct RectifiedLens {
    types::Camera camera;
    Eigen::Matrix3d R_camera_rectified = Eigen::Matrix3d::Identity();

    // Returns the pixel in the recorded image for a pixel in the rectified image.
    Eigen::Vector2d recorded_px(const types::RectifiedRig& rig,
                                const Eigen::Vector2d& rectified_px) const;
    // Returns the pixel in the rectified image for a pixel in the recorded image.
    Eigen::Vector2d rectified_px(const types::RectifiedRig& rig,
                                 const Eigen::Vector2d& recorded_px) const;
};

// Returns the lenses after rectification: each camera takes half of the rotation between them, then
// the row axis is laid along the baseline (Bouguet).
std::array<RectifiedLens, 2> rectified_lenses(const types::Rig& rig);  // left, right

// Returns the lens of the right camera after a turn, in the same rectified images.
RectifiedLens turned_lens(const RectifiedLens& right, const types::CameraTurn& turn);

// Returns the camera of images at 1 / `reduction` of their size, squares of pixels averaged.
types::Camera reduced_camera(const types::Camera& camera, int reduction);
// Returns an image of that camera: averages squares of pixels; what is left over at the right and
// at the bottom is cut off. An empty image stays empty.
cv::Mat reduced_image(const cv::Mat& image, int reduction);

// Returns the camera with `change` added to its calibration.
types::Camera changed_camera(const types::Camera& camera, const types::LensChange& change);

// Returns d(u, v)/d(change): how far a ray's pixel moves in the rectified image, as it was made, if
// the camera differs by `change` from the calibration used for rectification. Linear in the change.
Eigen::Matrix<double, 2, types::LensChange::kSize> shift_of_change(
    const types::RectifiedRig& rig, const RectifiedLens& lens, const Eigen::Vector2d& rectified_px);

}  // namespace divemesh::camera
