#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <span>

#include "worker/fusion/depth_view.hpp"

namespace divemesh::fusion {

// A frame near a view, as far as it can say something about the view's surface.
struct OtherFrame {
    Eigen::Isometry3d T_other_cam;  // maps the view's camera to this frame's
    cv::Mat disparity_px;           // CV_32F, every step_px-th of every step_px-th row; 0: unknown
    int step_px = 1;
};

// Marks the pixels of a view whose surface none of the other frames measured: at the borders of a
// dive, between stills that overlap little, where something hides it from them, and where they
// could not match their images. No other frame can confirm or refute a depth there, so it may be
// surface by itself. All frames have the view's rig.
void mark_unshared(std::span<const OtherFrame> others, DepthView& view);

}  // namespace divemesh::fusion
