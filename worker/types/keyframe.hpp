#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "worker/types/exposure_motion.hpp"
#include "worker/types/range_table.hpp"
#include "worker/types/search_outcome.hpp"

namespace divemesh::types {

// The disparities of a stereo pair, in the rectified left image.
struct DepthMap {
    cv::Mat disparity_px;        // CV_32F, height x width; <= 0: unknown
    cv::Mat sigma_disparity_px;  // CV_32F, standard deviation; where disparity_px > 0
    SearchOutcome search;        // not kept in the store
};

// A rectified stereo pair.
struct RectifiedFrame {
    int index = 0;
    std::int64_t timestamp_ns = 0;
    cv::Mat left;   // CV_8UC1
    cv::Mat right;  // CV_8UC1
    // CV_8UC1, 255 where `left` shows a fixed pattern (Recording::fixed_pattern()) instead of the
    // scene; empty: nowhere.
    cv::Mat fixed_pattern = {};
    // Set if `right` was exposed at another time and is warped to the time of `left`.
    std::optional<ExposureMotion> between = std::nullopt;
    // Set if a camera is behind a port: the images are those of an ideal pair at one depth alone.
    std::shared_ptr<const RangeTable> ranges = nullptr;
    // How much later the right image was exposed than the left one; negative: before it.
    double right_delay_s = 0.0;

    // Returns false where the left image shows a fixed pattern.
    bool shows_scene(const Eigen::Vector2d& pixel) const {
        const cv::Point nearest(static_cast<int>(std::lround(pixel.x())),
                                static_cast<int>(std::lround(pixel.y())));
        return !cv::Rect({}, fixed_pattern.size()).contains(nearest) ||
               fixed_pattern.at<std::uint8_t>(nearest) == 0;
    }
    // Returns true if disparities are used as they are matched.
    bool is_ideal() const { return !between && !ranges; }
    // Returns the disparity that an ideal pair shows at the time of `left` of what is matched in
    // `right`, and the inverse.
    double disparity_px(const Eigen::Vector2d& pixel, double matched_px) const {
        const double seen_px = between ? between->disparity_px(pixel, matched_px) : matched_px;
        return ranges ? seen_px + range_shift_px(pixel, seen_px) : seen_px;
    }
    double matched_px(const Eigen::Vector2d& pixel, double disparity_px) const {
        double seen_px = disparity_px;
        if (ranges)
            for (int i = 0; i < kIterations; ++i)
                seen_px = disparity_px - range_shift_px(pixel, seen_px);
        return between ? between->matched_px(pixel, seen_px) : seen_px;
    }

private:
    static constexpr int kIterations = 3;

    double range_shift_px(const Eigen::Vector2d& pixel, double seen_px) const {
        return ranges->shift_px({pixel.x(), pixel.y(), seen_px}).z();
    }
};

// A frame that is kept for mapping. Its images and depth are in the keyframe store under the same
// frame index. Keyframes of different segments are related by a guess alone.
struct Keyframe {
    int frame_index = 0;
    std::int64_t timestamp_ns = 0;
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();  // rectified left camera
    std::int32_t segment = 0;
};

// The image and the depth of a keyframe.
struct KeyframeImages {
    cv::Mat left_color;  // CV_8UC3 BGR, rectified; grey dives: three equal channels
    DepthMap depth;      // empty when no surface is requested
};

}  // namespace divemesh::types
