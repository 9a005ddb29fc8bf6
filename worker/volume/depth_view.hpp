#pragma once

#include <cstdint>
#include <vector>

#include "worker/geometry/rectified_rig.hpp"
#include "worker/instructions.hpp"
#include "worker/keyframe.hpp"

namespace divemesh::worker {

// Eight numbers that are read at once: the surface as one pixel saw it, its tangent plane in the
// camera frame. A point p_cam lies offset_m - normal . p_cam in front of it (toward the camera;
// negative: behind).
struct alignas(32) SurfacePixel {
    float normal[3] = {};  // unit, away from the camera
    float offset_m = 0.0F;
    float sigma_disparity_px = 0.0F;
    float depth_m = 0.0F;
    float weight = 0.0F;  // 0: unknown; falls at grazing angles and toward depth discontinuities
    std::uint32_t color = 0;  // red, green and blue from bit 16 down
};

// A keyframe's depth and picture made ready for fusion. A plane is linear in disparity, so the
// tangent plane comes from the disparity's gradient over a few pixels. Pixels at a jump of the
// disparity, where matchers let the foreground grow, and at the rim of the unknown weigh nothing.
class DepthView {
public:
    DepthView(const RectifiedRig& rig,
              const KeyframeImages& images,
              int num_threads = 1,
              Instructions instructions = best_instructions());

    const SurfacePixel& pixel(int u_px, int v_px) const {
        return pixels_[static_cast<std::size_t>(v_px) * width_px_ + u_px];
    }
    const SurfacePixel* pixels() const { return pixels_.data(); }  // row by row
    int width_px() const { return width_px_; }
    int height_px() const { return height_px_; }

private:
    int width_px_;
    int height_px_;
    std::vector<SurfacePixel> pixels_;
};

}  // namespace divemesh::worker
