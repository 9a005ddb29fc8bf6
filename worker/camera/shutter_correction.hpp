#pragma once

#include <map>
#include <opencv2/core/mat.hpp>

#include "worker/camera/rolling_shutter.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::camera {

// Whole keyframes as a camera would have seen them that reads all rows at the time of the middle
// one. Thread-safe after construction.
class ShutterCorrection {
public:
    // `motions`: of the camera, by index of the frame.
    ShutterCorrection(const types::RectifiedRig& rig,
                      const RectifiedLens& left,
                      double readout_time_s,
                      std::map<int, CameraMotion> motions);

    // Returns the resampled left image and depth. A pixel without disparity moves as one with
    // the mean of the others. Returns frames of unknown motion, or without any disparity, as they
    // are.
    types::KeyframeImages moved(int frame_index, const types::KeyframeImages& images) const;

private:
    types::RectifiedRig rig_;
    RollingShutter shutter_;
    std::map<int, CameraMotion> motions_;
    cv::Mat late_s_;  // CV_32F: when a pixel was read, s after the middle row
};

}  // namespace divemesh::camera
