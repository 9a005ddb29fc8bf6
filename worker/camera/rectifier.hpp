#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/types/rectified_rig.hpp"
#include "worker/types/rig.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::worker {

// Undistorts a pair and turns both images into one plane (Bouguet's method, as OpenCV's
// stereoRectify). Thread-safe after construction.
class Rectifier {
public:
    explicit Rectifier(const Rig& rig);

    const RectifiedRig& rig() const { return rig_; }
    RectifiedFrame rectify(const StereoFrame& frame) const;
    // The left picture, any number of channels.
    cv::Mat rectify_left(const cv::Mat& image) const;

private:
    RectifiedRig rig_;
    cv::Mat left_map_[2];
    cv::Mat right_map_[2];
};

}  // namespace divemesh::worker
