#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace divemesh::types {

// The photographs of a mesh, packed into atlases.
struct Texture {
    static constexpr std::int32_t kUntextured = -1;
    std::vector<cv::Mat> atlases;                 // CV_8UC3 BGR, at most 8192 x 8192
    std::vector<std::int32_t> atlas_of_triangle;  // or kUntextured
    // of every triangle's corners, 0 to 1 over its atlas, v down (as glTF)
    std::vector<std::array<Eigen::Vector2f, 3>> uv;
};

}  // namespace divemesh::types
