#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace divemesh::features {

// 256 brightness comparisons around a corner, rotated to the corner's orientation.
using Descriptor = std::array<std::uint64_t, 4>;

// Returns the number of differing bits.
inline int hamming_distance(const Descriptor& a, const Descriptor& b) {
    int bits = 0;
    for (std::size_t i = 0; i < a.size(); ++i) bits += std::popcount(a[i] ^ b[i]);
    return bits;
}

// A corner with its descriptor, in the rectified left image.
struct DescribedKeypoint {
    float u_px = 0.0F;
    float v_px = 0.0F;
    float disparity_px = 0.0F;  // <= 0: unknown
    float scale = 1.0F;         // pixel size of its pyramid level, px
    float direction_rad = 0.0F;
    Descriptor descriptor{};
};

// The keypoints by which a keyframe is recognised: corners at four scales, spread over the image,
// at most 500.
using DescribedKeypoints = std::vector<DescribedKeypoint>;

// Returns the pixel size of the finest of these scales, px: 1, but images of more than 832 px are
// described at 720 px (the longer side), so that the keypoints are spread over all of it.
double description_scale(cv::Size size);

// Returns the keypoints of an image (CV_8UC1); their disparities are unknown. Corners are chosen by
// score (Shi and Tomasi 1994). Their orientation (by the intensity centroid) and the rotated binary
// tests are as in ORB (Rublee et al. 2011). The tests are drawn as in BRIEF (Calonder et al. 2010,
// G II).
DescribedKeypoints describe_keypoints(const cv::Mat& left);

}  // namespace divemesh::features
