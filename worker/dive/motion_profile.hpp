#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

namespace divemesh::dive {

// How the image of one camera moves as a whole.
struct MotionSample {
    double time_s = 0.0;  // by the camera's own clock
    Eigen::Vector2d flow_1_s =
        Eigen::Vector2d::Zero();  // median over the image, in widths a second
};
using MotionProfile = std::vector<MotionSample>;  // in the order of time

// Follows corners from image to image. `load` returns an image by its index, empty if there is
// none; `timestamps_ns` are those of the images, counted from `start_ns`.
MotionProfile motion_profile(const std::vector<std::int64_t>& timestamps_ns,
                             std::int64_t start_ns,
                             const std::function<cv::Mat(std::size_t index)>& load);

// The lag at which two profiles agree best: right time = left time + lag.
struct ProfileLag {
    double lag_s = 0.0;
    double correlation = 0.0;  // there, at most 1
    double runner_up = 0.0;    // the best correlation at lags that differ clearly
    bool is_clear() const;
};

// Searches lags up to `max_lag_s` on both sides; nullopt if the profiles are too short.
std::optional<ProfileLag> find_lag(const MotionProfile& left,
                                   const MotionProfile& right,
                                   double max_lag_s);

}  // namespace divemesh::dive
