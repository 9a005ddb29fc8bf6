#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <opencv2/core/types.hpp>

namespace divemesh::base {

// Returns the pixels of an image (centres at integers) that cover a triangle, and those beside them
// between which a point at its edge is interpolated.
inline cv::Rect pixels_around(const std::array<Eigen::Vector2d, 3>& corners) {
    const Eigen::Vector2d low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
    const Eigen::Vector2d high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
    const cv::Point first(static_cast<int>(std::floor(low.x())),
                          static_cast<int>(std::floor(low.y())));
    const cv::Point last(static_cast<int>(std::ceil(high.x())),
                         static_cast<int>(std::ceil(high.y())));
    return {first, last + cv::Point(1, 1)};
}

}  // namespace divemesh::base
