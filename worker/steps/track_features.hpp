#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <unordered_set>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/geometry/rectified_rig.hpp"
#include "worker/steps/feature.hpp"

namespace divemesh::worker {

// Step 2: salient features followed from picture to picture (Kanade-Lucas-Tomasi).
class FeatureTracker {
public:
    FeatureTracker(const RectifiedRig& rig, const ReconstructionOptions& options);

    // Finds `previous`, features of the picture before, in `left`; the camera's expected motion
    // says where to look. A feature stays only when tracking it back ends where it began. Its
    // disparity is what the motion lets expect, to be measured.
    Features track(const cv::Mat& left,
                   const Features& previous,
                   const Eigen::Isometry3d& T_cam_previous);

    // New features with fresh ids where the last picture has none, spread over a grid, best corner
    // (Shi and Tomasi) of each cell.
    Features detect(const Features& present);

private:
    RectifiedRig rig_;
    int cell_px_ = 0;
    std::int64_t next_id_ = 0;
    std::vector<cv::Mat> pyramid_;  // of the last picture
    cv::Mat left_;
};

}  // namespace divemesh::worker
