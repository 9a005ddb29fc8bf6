#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace divemesh::types {

// Where the triangles of a mesh are in its atlases. Triangles that no photograph shows well stay
// untextured.
struct TextureMap {
    static constexpr std::int32_t kUntextured = -1;
    // Texels around the charts in an atlas that go on as they do, so that smaller mip levels do not
    // mix them with their neighbours. A chart is a connected part of the surface that takes its
    // colour from one keyframe.
    static constexpr int kBorder_px = 4;

    std::vector<std::int32_t> atlas_of_triangle;  // or kUntextured
    // The corners of each triangle, 0 to 1 over its atlas, v down (as glTF); 0 if untextured.
    std::vector<std::array<Eigen::Vector2f, 3>> uv;
};

// The photographs of a mesh, packed into atlases.
struct Texture : TextureMap {
    std::vector<cv::Mat> atlases;   // CV_8UC3 BGR
    double texels_per_pixel = 1.0;  // of the photographs, along a row; below 1: limited by memory
};

}  // namespace divemesh::types
