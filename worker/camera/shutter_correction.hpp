#pragma once

#include <Eigen/Geometry>
#include <map>
#include <opencv2/core/mat.hpp>

#include "worker/camera/rolling_shutter.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::camera {

// Moves images and depth to where a global shutter would have seen them at the time of the middle
// row. The constructor works on `num_threads` threads (0: all cores). Thread-safe after
// construction.
class ShutterCorrection {
public:
    // `motions`: of the camera, by index of the frame.
    ShutterCorrection(const types::RectifiedRig& rig,
                      const RectifiedLens& left,
                      double readout_time_s,
                      std::map<int, CameraMotion> motions,
                      int num_threads = 0);

    // Returns the resampled left image and depth. A pixel without disparity moves as one with
    // the mean of the others. Returns frames of unknown motion, or without any disparity, as they
    // are.
    types::KeyframeImages moved(int frame_index, const types::KeyframeImages& images) const;

    // Returns how the camera moves from the time of the middle row to that of a pixel's row:
    // T_middle_row. Identity for frames of unknown motion.
    Eigen::Isometry3d motion_until_row(int frame_index, const Eigen::Vector2d& seen_px) const;

private:
    types::RectifiedRig rig_;
    RollingShutter shutter_;
    double readout_time_s_ = 0.0;
    std::map<int, CameraMotion> motions_;
    cv::Mat late_s_;  // CV_32F: when a pixel was read, s after the middle row
};

}  // namespace divemesh::camera
