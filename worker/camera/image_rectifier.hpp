#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/camera/rectified_lens.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::camera {

// The rectification of the images of one camera. The constructor computes its map on
// `num_threads` threads (0: all cores).
// Thread-safe after construction.
class ImageRectifier {
public:
    ImageRectifier(const RectifiedLens& lens, const types::RectifiedRig& rig, int num_threads = 0);

    // Returns the rectified image; any number of channels.
    cv::Mat rectify(const cv::Mat& image) const;
    // Returns the rectified mask (CV_8UC1), with 255 beyond the recorded image.
    cv::Mat rectify_mask(const cv::Mat& mask) const;

private:
    // The recorded pixel of every rectified pixel, as cv::remap() reads it: whole pixels (CV_16SC2)
    // and parts (CV_16UC1).
    cv::Mat pixels_;
    cv::Mat parts_;
};

}  // namespace divemesh::camera
