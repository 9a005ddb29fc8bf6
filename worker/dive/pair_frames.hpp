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

// What timestamps and images say about the gap between the exposures of a pair. It varies if
// cameras run free, or their triggers jitter.
enum class PairGaps {
    Constant,     // by the timestamps it is the same for all pairs, as far as it matters
    Stated,       // it varies by the timestamps; the images show too little to tell
    Confirmed,    // it varies, and the images fit better with it
    Contradicted  // it varies by the timestamps, but the images fit better without
};

// The frames of a dive, paired by timestamps and images.
struct PairedFrames {
    std::vector<FramePair> pairs;
    ClockDifference clocks;
    PairGaps gaps = PairGaps::Constant;
    StereoDelay delay;             // between the images of a pair; beyond its gap if that is used
    std::vector<int> moments;      // the pairs of delay.by_moment_s
    bool has_right_clock = false;  // timestamps of the pairs are by the right clock

    // Returns the gap by the timestamps, without the difference of the clocks: right minus left.
    std::int64_t gap_ns(const FramePair& pair) const;
    bool gaps_vary() const;  // by the timestamps, from pair to pair
    bool uses_gaps() const { return gaps == PairGaps::Stated || gaps == PairGaps::Confirmed; }
    // Returns how much later the right image of a pair was exposed, by timestamps and images; 0 if
    // neither shows a difference.
    double right_delay_s(const FramePair& pair) const;
};

// Pairs the images of two cameras. Where timestamps of both do not agree, or the images contradict
// them, it searches for the difference of the clocks: by the motion of both images over time, then
// by how features leave their epipolar lines as they move; a drift too, if the dive shows it. What
// varies from pair to pair then is the real gap between exposures, unless the images contradict.
// There are no pairs if the clocks differ and the images contradict; images that show too little to
// tell are paired by their timestamps.
PairedFrames pair_frames(const CameraImages& images, const types::Rig& rig);

// Gives the pairs the timestamps of the right clock, where the other sensors follow that.
void use_right_clock(PairedFrames& frames);

// Reports pairs that were not exposed together, clocks that differ, and images without a partner.
void report_pairs(const PairedFrames& frames,
                  const CameraImages& images,
                  double baseline_m,
                  FindingLog& findings);

}  // namespace divemesh::dive
