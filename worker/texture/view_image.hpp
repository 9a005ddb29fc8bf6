#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/keyframes/keyframe_images.hpp"

namespace divemesh::texture {

// A keyframe's image with what is compared between keyframes. Both are means over a few pixels, so
// that a pose that is wrong by one pixel changes them little.
struct ViewImage {
    cv::Mat color;      // CV_8UC3 BGR, smoothed
    cv::Mat sharpness;  // CV_32F, mean gradient magnitude around the pixel, grey levels per px

    bool is_empty() const { return color.empty(); }
};

// Returns the image of a frame; grey ones as BGR. Empty where it cannot be read. Throws
// Error{Cancelled} as `read_image` does.
ViewImage read_view_image(const keyframes::ReadImage& read_image, int frame_index);

}  // namespace divemesh::texture
