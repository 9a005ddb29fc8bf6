#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace divemesh::stereo {

// Sets islands of fewer than `min_pixels` connected pixels to unknown (0). Neighbours are connected
// if they differ by at most `max_step_px`. CV_32F disparity, px; <= 0: unknown.
void remove_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px);

// The same, but makes them negative, i.e. unconfirmed winners of a matcher.
void unconfirm_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px);

// The support that distinguishes a surface from a chance match, which is an island too and may be
// as large.
struct IslandSupport {
    float certain_px = 0.17F;        // a smaller sigma is that of visible texture
    std::int32_t num_certain = 40;   // pixels, of visible texture
    std::int32_t num_pixels = 2000;  // or so many of any texture
};

// The limits of islands in an image. Chance matches are as large a part of any image, so in images
// of more than 832 px the limits in pixels grow with the area, relative to 640 x 480; in smaller
// ones they are those of 640 x 480.
struct IslandLimits {
    std::int32_t min_pixels = 120;
    IslandSupport min_support;

    static IslandLimits of(cv::Size image);
};

// Sets the disparities of islands with less support to 0.
void remove_unsupported(cv::Mat& disparity_px,
                        const cv::Mat& sigma_px,
                        const IslandSupport& min_support,
                        float max_step_px);

}  // namespace divemesh::stereo
