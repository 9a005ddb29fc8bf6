#pragma once

#include <Eigen/Core>

#include "worker/fusion/depth_view.hpp"

namespace divemesh::fusion {

// One keyframe as it is integrated into a TSDF: its pixels, camera, pose and limits.
struct TsdfView {
    const SurfacePixel* pixels = nullptr;  // row by row
    int width_px = 0;
    int height_px = 0;
    float focal_px = 0.0F;
    float cx_px = 0.0F;
    float cy_px = 0.0F;
    Eigen::Matrix3f R_cam_world;
    Eigen::Vector3f t_cam_world;
    float voxel_m = 0.0F;
    float max_depth_m = 0.0F;
    float max_sigma_m = 0.0F;        // largest of a depth that may make surface
    float depth_sigma_scale = 0.0F;  // 1 / (f b): sigma_z = z^2 sigma_d times this
};

// Samples are truncated at the larger of these two.
inline constexpr float kTruncation_voxels = 3.0F;
inline constexpr float kTruncation_sigmas = 2.0F;

// Returns whether a pixel may make surface; otherwise it only carves the space in front of it.
inline bool makes_surface(const TsdfView& view, const SurfacePixel& pixel) {
    const float z = pixel.depth_m;
    return pixel.weight > 0.0F && z <= view.max_depth_m &&
           z * z * (pixel.sigma_disparity_px * view.depth_sigma_scale) <= view.max_sigma_m;
}

}  // namespace divemesh::fusion
