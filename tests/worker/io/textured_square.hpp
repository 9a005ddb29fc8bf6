#pragma once

#include <opencv2/core.hpp>

#include "worker/types/mesh.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::io {

// A square of two triangles with one atlas of four colours, a quarter each, and a third triangle
// beside it without texture.
struct TexturedSquare {
    TexturedSquare() {
        mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}};
        mesh.colors.assign(5, {255, 255, 255});
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}};
        cv::Mat atlas(64, 64, CV_8UC3);
        atlas(cv::Rect(0, 0, 32, 32)) = kTopLeft;
        atlas(cv::Rect(32, 0, 32, 32)) = cv::Scalar(40, 200, 40);
        atlas(cv::Rect(0, 32, 32, 32)) = kBottomLeft;
        atlas(cv::Rect(32, 32, 32, 32)) = cv::Scalar(128, 128, 128);
        texture.atlases = {cv::Mat(4, 4, CV_8UC3), atlas};
        texture.atlas_of_triangle = {1, 1, types::Texture::kUntextured};
        // The square's y is up in the image: its (0, 0) is the lower left corner.
        const Eigen::Vector2f a(0.1F, 0.9F), b(0.9F, 0.9F), c(0.9F, 0.1F), d(0.1F, 0.1F);
        texture.uv = {{a, b, c}, {a, c, d}, {a, a, a}};
    }
    static inline const cv::Scalar kTopLeft{200, 40, 40};
    static inline const cv::Scalar kBottomLeft{40, 40, 200};
    types::Mesh mesh;
    types::Texture texture;
};

}  // namespace divemesh::io
