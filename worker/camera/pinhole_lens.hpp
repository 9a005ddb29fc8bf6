#pragma once

#include "worker/camera/lens_parts.hpp"

namespace divemesh::camera {

inline Eigen::Vector2d keep_straight(const types::LensCoefficients&, const Eigen::Vector2d& n) {
    return n;
}

inline constexpr LensModel kPinholeLens = {.distortion = types::Distortion::None,
                                           .name = "none",
                                           .camera_model = "pinhole",
                                           .distortion_models = kNoDistortion,
                                           .num_coefficients = 0,
                                           .leading = {},
                                           .is_fisheye = false,
                                           .focal_factor = same_focal_length,
                                           .distort = keep_straight,
                                           .undistort = keep_straight};

}  // namespace divemesh::camera
