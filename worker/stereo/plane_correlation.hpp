#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "worker/stereo/neighbour_view.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::stereo {

// A plane is linear in disparity.
struct Plane {
    float disparity_px = 0.0F;
    float slope_u = 0.0F;
    float slope_v = 0.0F;

    // The same plane at another pixel.
    Plane moved(int du, int dv) const {
        const float there_px =
            disparity_px + slope_u * static_cast<float>(du) + slope_v * static_cast<float>(dv);
        return {there_px, slope_u, slope_v};
    }
};

// How well planes explain what the frames around a pair show, at a reduced size: all sizes,
// disparities and gradients are those of the reduced image.
class PlaneCorrelation {
public:
    static constexpr int kMargin_px = 4;         // of a window; none fits nearer to the border
    static constexpr std::size_t kNumViews = 2;  // that have to show a surface
    static constexpr float kWorst = 2.0F;        // cost of what is out of sight

    // Reduces the images to 1 / `step_px` of their size. At least kNumViews neighbours.
    PlaneCorrelation(const types::RectifiedRig& rig,
                     const cv::Mat& left,
                     std::span<const NeighbourView> neighbours,
                     int step_px);

    const types::RectifiedRig& rig() const { return rig_; }

    // The window around a pixel: the samples without their mean, their weights, which sum to 1, and
    // their variance.
    struct Window {
        static constexpr int kSide = 5;
        static constexpr int kNumSamples = kSide * kSide;
        std::array<float, kNumSamples> value;
        std::array<float, kNumSamples> weight;
        float variance = 0.0F;
    };
    Window window_at(int u, int v) const;

    // Returns true if the window shows more than noise.
    bool has_texture(const Window& window) const {
        return window.variance >= min_deviation_ * min_deviation_;
    }

    struct Score {
        float cost = kWorst;                         // 1 - correlation, mean of the best views
        std::array<std::size_t, kNumViews> views{};  // the best ones
    };
    Score score(const Window& window, int u, int v, const Plane& plane) const;

    // Returns the sigma of the plane's disparity by the curvature of the correlation; infinite if
    // there is no peak.
    float sigma_px(int u, int v, const Plane& plane) const;

private:
    float cost_in(std::size_t view, const Window& window, int u, int v, const Plane& plane) const;
    float shift_px(std::size_t view, int u, int v, float disparity_px) const;

    types::RectifiedRig rig_;
    cv::Mat left_;                // CV_32F
    std::vector<cv::Mat> views_;  // CV_32F
    std::vector<ViewProjection> projections_;
    float min_deviation_ = 0.0F;
};

}  // namespace divemesh::stereo
