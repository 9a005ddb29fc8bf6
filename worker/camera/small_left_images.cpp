#include "worker/camera/small_left_images.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::camera {
namespace {

// Returns the largest reduction of the decoder that leaves an image at least as wide.
int reduction_to(int width_px, int min_width_px) {
    int reduction = 1;
    while (reduction < 8 && width_px / (2 * reduction) >= min_width_px) reduction *= 2;
    return reduction;
}

// Pixel centres are whole numbers in both sizes.
types::RectifiedRig resized(const types::RectifiedRig& rig, int width_px) {
    const double scale = std::min(1.0, static_cast<double>(width_px) / rig.width_px);
    types::RectifiedRig result = rig;
    result.width_px = static_cast<int>(std::lround(scale * rig.width_px));
    result.height_px = static_cast<int>(std::lround(scale * rig.height_px));
    result.focal_px = scale * rig.focal_px;
    result.cx_px = scale * (rig.cx_px + 0.5) - 0.5;
    result.cy_px = scale * (rig.cy_px + 0.5) - 0.5;
    return result;
}

}  // namespace

SmallLeftImages::SmallLeftImages(const types::Recording& recording,
                                 const RectifiedLens& left,
                                 const types::RectifiedRig& rig,
                                 int width_px,
                                 int num_threads)
    : recording_(recording),
      reduction_(reduction_to(rig.width_px, width_px)),
      rectifier_({reduced_camera(left.camera, reduction_), left.R_camera_rectified},
                 resized(rig, width_px),
                 num_threads) {}

cv::Mat SmallLeftImages::read(int frame_index) const {
    return rectifier_.rectify(recording_.left_in_color(frame_index, reduction_));
}

}  // namespace divemesh::camera
