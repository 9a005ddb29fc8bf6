#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/dive/stereo_delay.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::dive {

// The images of both cameras by their rows. Several threads load at once.
struct CameraImages {
    std::vector<CameraRow> left;
    std::vector<CameraRow> right;
    std::function<cv::Mat(const CameraRow&)> load_left;  // grey; empty if it cannot be loaded
    std::function<cv::Mat(const CameraRow&)> load_right;
};

// The frames of a dive, paired by timestamps and images.
struct PairedFrames {
    std::vector<FramePair> pairs;
    ClockDifference clocks;
    StereoDelay delay;             // that is left between the images of a pair
    std::vector<int> moments;      // the pairs of delay.by_moment_s
    bool has_right_clock = false;  // timestamps of the pairs are by the right clock
};

// Pairs the images of two cameras. Where timestamps of both do not agree, or the images contradict
// them, it searches for the difference of the clocks: by the motion of both images over time, then
// by how features leave their epipolar lines as they move; a drift too, if the dive shows it. There
// are no pairs if the clocks differ and the images contradict; images that show too little to tell
// are paired by their timestamps.
PairedFrames pair_frames(const CameraImages& images, const types::Rig& rig);

// Gives the pairs the timestamps of the right clock, where the other sensors follow that.
void use_right_clock(PairedFrames& frames);

// Reports pairs that were not exposed together, clocks that differ, and images without a partner.
void report_pairs(const PairedFrames& frames,
                  const CameraImages& images,
                  double baseline_m,
                  FindingLog& findings);

}  // namespace divemesh::dive
