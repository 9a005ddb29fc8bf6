#pragma once

#include <cstdint>
#include <vector>

#include "worker/base/instructions.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::fusion {

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

// Every pixel, or one for every two by two: their mean, where all four see one surface.
enum class Sampling { Full, Half };

// Half where a voxel covers two pixels or more at the median depth of the view: finer pixels would
// say nothing more about it.
Sampling choose_sampling(const types::RectifiedRig& rig,
                         const types::DepthMap& depth,
                         double voxel_m);

// A keyframe's depth and picture made ready for fusion. A plane is linear in disparity, so the
// tangent plane comes from the disparity's gradient over a few pixels. Pixels at a jump of the
// disparity, where matchers let the foreground grow, and at the rim of the unknown weigh nothing.
class DepthView {
public:
    DepthView(const types::RectifiedRig& rig,
              const types::KeyframeImages& images,
              Sampling sampling = Sampling::Full,
              base::Instructions instructions = base::best_instructions());

    // The camera of these pixels: that of the keyframe, or with half as many either way.
    const types::RectifiedRig& rig() const { return rig_; }
    const SurfacePixel& pixel(int u_px, int v_px) const {
        return pixels_[static_cast<std::size_t>(v_px) * rig_.width_px + u_px];
    }
    const SurfacePixel* pixels() const { return pixels_.data(); }  // row by row
    int step_px() const { return step_px_; }  // of the keyframe's pixels between two of these
    const cv::Mat& image() const { return image_; }  // CV_8UC3, all of the keyframe's pixels

private:
    int step_px_;
    types::RectifiedRig rig_;
    cv::Mat image_;
    std::vector<SurfacePixel> pixels_;
};

}  // namespace divemesh::fusion
