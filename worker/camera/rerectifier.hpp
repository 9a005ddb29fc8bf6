#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>

#include "worker/camera/rectified_lens.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::camera {

// The mapping of measurements to where they would lie if the pair had been rectified with changed
// lenses into the same ideal pair.
class Rerectifier {
public:
    Rerectifier(const types::Rig& rig,
                const types::RectifiedRig& rectified,
                const std::array<types::LensChange, 2>& change);  // left, right

    // Returns the mapped (u, v, disparity); a disparity <= 0 (unknown) stays unknown.
    Eigen::Vector3d moved(const Eigen::Vector3d& measured_px) const;
    // Map a pixel from the old to the new image of a side (0: left, 1: right), and back.
    Eigen::Vector2d forward(std::size_t side, const Eigen::Vector2d& pixel) const;
    Eigen::Vector2d back(std::size_t side, const Eigen::Vector2d& pixel) const;

private:
    types::RectifiedRig rectified_;
    std::array<RectifiedLens, 2> stated_;
    std::array<RectifiedLens, 2> refined_;
};

// The same mapping for whole keyframes. The constructor computes it on `num_threads`
// threads (0: all cores). Thread-safe after construction.
class KeyframeRerectifier {
public:
    KeyframeRerectifier(const types::RectifiedRig& rectified,
                        const Rerectifier& rerectifier,
                        int num_threads = 0);

    // Returns the resampled left image (empty if it is), and depth by mapping both ends of every
    // disparity. Rows stay as they were when the pair was matched: a vertical error of the right
    // lens is not corrected.
    types::KeyframeImages moved(const types::KeyframeImages& images) const;
    cv::Mat moved(const cv::Mat& left) const;

private:
    cv::Mat source_x_;  // CV_32F: column of a new left pixel in the old left image
    cv::Mat source_y_;
    cv::Mat nearest_;      // CV_32S: index of the nearest old pixel, or -1
    cv::Mat shift_right_;  // CV_32F: new u minus old u in the right image, at old u and v
};

}  // namespace divemesh::camera
