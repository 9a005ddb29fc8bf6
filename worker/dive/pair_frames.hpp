#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/dive/paired_frames.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::dive {

// The images of both cameras by their rows. Several threads load at once.
struct CameraImages {
    std::vector<CameraRow> left;
    std::vector<CameraRow> right;
    std::function<cv::Mat(const CameraRow&)> load_left;  // grey; empty if it cannot be loaded
    std::function<cv::Mat(const CameraRow&)> load_right;
};

// Pairs the images of two cameras. Where timestamps of both do not agree, or the images contradict
// them, it searches for the difference of the clocks: by the motion of both images over time, then
// by how features leave their epipolar lines as they move; a drift too, if the dive shows it. What
// varies from pair to pair then is the real gap between exposures, unless the images contradict.
// There are no pairs if the clocks differ and the images contradict; images that show too little to
// tell are paired by their timestamps.
PairedFrames pair_frames(const CameraImages& images, const types::Rig& rig);

// Reports pairs that were not exposed together, clocks that differ, and images without a partner.
void report_pairs(const PairedFrames& frames,
                  const CameraImages& images,
                  double baseline_m,
                  FindingLog& findings);

}  // namespace divemesh::dive
