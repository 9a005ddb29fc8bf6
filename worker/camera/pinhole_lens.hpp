#pragma once

#include "worker/camera/lens_parts.hpp"

namespace divemesh::camera {

template <typename Coefficients, typename T>
Eigen::Vector2<T> keep_straight(const Coefficients&, const Eigen::Vector2<T>& n) {
    return n;
}

inline constexpr LensModel kPinholeLens = {.distortion = types::Distortion::None,
                                           .name = "none",
                                           .camera_model = "pinhole",
                                           .distortion_models = kNoDistortion,
                                           .num_coefficients = 0,
                                           .leading = {},
                                           .starts = kStraightStart,
                                           .is_fisheye = false,
                                           .focal_factor = same_focal_length,
                                           .distort = keep_straight,
                                           .undistort = keep_straight};

}  // namespace divemesh::camera
