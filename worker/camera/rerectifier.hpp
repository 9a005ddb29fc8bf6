#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>

#include "worker/camera/rectified_lens.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::camera {

// Where the same things would have been seen, had the pair been rectified with other lenses into
// the same ideal pair.
class Rerectifier {
public:
    Rerectifier(const types::Rig& rig,
                const types::RectifiedRig& rectified,
                const std::array<types::LensChange, 2>& change);  // left, right

    // (u, v, disparity); without disparity (<= 0) it stays so.
    Eigen::Vector3d moved(const Eigen::Vector3d& measured_px) const;
    // From the pixel as it was to the pixel as it would be, and back.
    Eigen::Vector2d forward(std::size_t side, const Eigen::Vector2d& pixel) const;
    Eigen::Vector2d back(std::size_t side, const Eigen::Vector2d& pixel) const;

private:
    types::RectifiedRig rectified_;
    std::array<RectifiedLens, 2> stated_;
    std::array<RectifiedLens, 2> refined_;
};

// The same for whole keyframes. Thread-safe after construction.
class KeyframeRerectifier {
public:
    KeyframeRerectifier(const types::RectifiedRig& rectified, const Rerectifier& rerectifier);

    // The left picture resampled; depth from both ends of every disparity. The rows along which the
    // pair was matched stay what they were: a vertical error of the right lens is not undone.
    types::KeyframeImages moved(const types::KeyframeImages& images) const;
    cv::Mat moved(const cv::Mat& left) const;

private:
    cv::Mat source_x_;  // CV_32F: where a pixel of the new left picture lies in the old one
    cv::Mat source_y_;
    cv::Mat nearest_;      // CV_32S: index of the old pixel nearest to it, or -1
    cv::Mat shift_right_;  // CV_32F: new u minus old u in the right picture, by old u and v
};

}  // namespace divemesh::camera
