#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace divemesh::features {

// 256 comparisons of brightness around a corner, taken in the corner's own direction.
using Descriptor = std::array<std::uint64_t, 4>;

inline int hamming_distance(const Descriptor& a, const Descriptor& b) {
    int bits = 0;
    for (std::size_t i = 0; i < a.size(); ++i) bits += std::popcount(a[i] ^ b[i]);
    return bits;
}

struct DescribedKeypoint {
    float u_px = 0.0F;
    float v_px = 0.0F;
    float disparity_px = 0.0F;  // <= 0: unknown
    float scale = 1.0F;         // size of a pixel of its pyramid level, px
    float direction_rad = 0.0F;
    Descriptor descriptor{};
};

// What a keyframe is recognised by: corners at four scales, spread over the picture, at most 500.
using DescribedKeypoints = std::vector<DescribedKeypoint>;

// Corners by their score (Shi and Tomasi 1994), direction by the intensity centroid and binary
// tests turned with it as in ORB (Rublee et al. 2011); the tests are drawn as in BRIEF (Calonder et
// al. 2010, G II). `left` CV_8UC1. Disparities come out unknown.
DescribedKeypoints describe_keypoints(const cv::Mat& left);

}  // namespace divemesh::features
