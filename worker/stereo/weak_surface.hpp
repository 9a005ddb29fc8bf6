#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace divemesh::stereo {

// Surface between supported edges. Where texture is too weak to measure a disparity, a winner is
// accepted if the measured surface on opposite sides of it continues smoothly through it: a hull or
// a wall between what is visible on it. Open water has surface on one side at most.
class WeakSurface {
public:
    // Adds disparities where `disparity_px` (CV_32F) is 0, from `winners_px` (CV_32F, whatever the
    // sign), with a `sigma_px` that grows with the distance to what was measured.
    void add(const cv::Mat& winners_px, cv::Mat& disparity_px, cv::Mat& sigma_px);

private:
    // The nearest measured block in one direction.
    struct Support {
        float disparity_px = 0.0F;  // 0: there is none within reach
        float distance_px = 0.0F;
    };
    struct Plane {
        float disparity_px = 0.0F;  // at the centre of the block; 0: not supported
        float slope_x = 0.0F;
        float slope_y = 0.0F;
        float sigma_px = 0.0F;
        bool is_around = false;  // all around, at once: the gap is a small one
        float min_px = 0.0F;     // of the supports
        float max_px = 0.0F;
    };

    void measure_blocks(const cv::Mat& disparity_px);
    void look_along(int direction, int dx, int dy);
    Plane plane_of(std::size_t block) const;
    void add_block(const cv::Mat& winners_px,
                   int block_x,
                   int block_y,
                   const Plane& plane,
                   cv::Mat& disparity_px,
                   cv::Mat& sigma_px) const;

    int columns_ = 0;
    int rows_ = 0;
    float reach_px_ = 0.0F;
    std::vector<float> measured_px_;  // by block, 0: not measured
    std::vector<std::uint8_t> has_gaps_;
    std::vector<Support> supports_[8];
};

}  // namespace divemesh::stereo
