#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/base/instructions.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::fusion {

// The surface as one pixel saw it, as its tangent plane in the camera frame; eight values that are
// loaded together. A point p_cam lies offset_m - normal . p_cam in front of the plane (toward the
// camera; negative: behind).
struct alignas(32) SurfacePixel {
    float normal[3] = {};  // unit, away from the camera
    float offset_m = 0.0F;
    float sigma_disparity_px = 0.0F;
    float depth_m = 0.0F;
    float weight = 0.0F;  // 0: unknown; falls at grazing angles and toward depth discontinuities
    std::uint32_t color = 0;  // red, green and blue from bit 16 down; kUnshared

    // The bit in `color` of a surface that no other frame has in sight (unshared_depth.hpp).
    static constexpr std::uint32_t kUnshared = 1U << 24;
};

// Returns the median disparity of a depth map, px; 0 if none is known.
float median_disparity_px(const types::DepthMap& depth);

// Full: every pixel. Half: one for every 2 x 2 pixels, their mean if all four see one surface.
enum class Sampling { Full, Half };

// Returns Half if a voxel covers two pixels or more at the median depth of the view: finer pixels
// would add no information about it.
Sampling choose_sampling(const types::RectifiedRig& rig,
                         const types::DepthMap& depth,
                         double voxel_m);

// A keyframe's depth and image, prepared for fusion. A plane is linear in disparity, so the tangent
// plane comes from the gradient of the disparity over a few pixels. Pixels at a discontinuity of
// the disparity, where matchers enlarge the foreground, on bridges (mark_bridges.hpp) and at the
// border of unknown pixels have weight 0.
class DepthView {
public:
    DepthView(const types::RectifiedRig& rig,
              const types::KeyframeImages& images,
              Sampling sampling = Sampling::Full,
              base::Instructions instructions = base::best_instructions());

    // Returns the camera of these pixels: the keyframe's, or with Half the same at half the
    // resolution.
    const types::RectifiedRig& rig() const { return rig_; }
    const SurfacePixel& pixel(int u_px, int v_px) const {
        return pixels_[static_cast<std::size_t>(v_px) * rig_.width_px + u_px];
    }
    std::span<SurfacePixel> row(int v_px) {
        const auto width = static_cast<std::size_t>(rig_.width_px);
        return {pixels_.data() + v_px * width, width};
    }
    std::span<const SurfacePixel> row(int v_px) const {
        const auto width = static_cast<std::size_t>(rig_.width_px);
        return {pixels_.data() + v_px * width, width};
    }
    const SurfacePixel* pixels() const { return pixels_.data(); }  // row by row
    int step_px() const { return step_px_; }                       // keyframe pixels per pixel
    const cv::Mat& image() const { return image_; }                // CV_8UC3, at full resolution

private:
    int step_px_;
    types::RectifiedRig rig_;
    cv::Mat image_;
    std::vector<SurfacePixel> pixels_;
};

}  // namespace divemesh::fusion
