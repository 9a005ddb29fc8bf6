#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/geometry/rectified_rig.hpp"
#include "worker/keyframe.hpp"

namespace divemesh::worker {

// The surface as one pixel saw it: its tangent plane in the camera frame. A point p_cam lies
// offset_m - normal.dot(p_cam) in front of it (toward the camera; negative: behind).
struct SurfacePixel {
    Eigen::Vector3f normal;  // unit, away from the camera
    float offset_m = 0.0F;
    float sigma_disparity_px = 0.0F;
    float depth_m = 0.0F;
    float weight = 0.0F;  // 0: unknown; falls at grazing angles and toward depth discontinuities
};

// A keyframe's depth made ready for fusion. A plane is linear in disparity, so the tangent plane
// comes from the disparity's gradient over a few pixels. Pixels at a jump of the disparity, where
// matchers let the foreground grow, and at the rim of the unknown weigh nothing.
class DepthView {
public:
    DepthView(const RectifiedRig& rig, const DepthMap& depth);

    const SurfacePixel& pixel(int u_px, int v_px) const {
        return pixels_[static_cast<std::size_t>(v_px) * width_px_ + u_px];
    }
    int width_px() const { return width_px_; }
    int height_px() const { return height_px_; }

private:
    int width_px_;
    int height_px_;
    std::vector<SurfacePixel> pixels_;
};

}  // namespace divemesh::worker
