#pragma once

#include <vector>

#include "worker/dive/dive.hpp"
#include "worker/dive/dive_files.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/dive/pair_frames.hpp"

namespace divemesh::dive {

// All contents of a dive except its images, in the frames of Rig.
struct DiveContents {
    DiveInfo info;
    types::Rig rig;
    bool has_rig = false;  // both cameras are calibrated
    std::vector<CameraRow> left_rows;
    std::vector<CameraRow> right_rows;
    PairedFrames frames;    // set once the images can be read
    cv::Mat fixed_pattern;  // mask of left images; empty: none, or images were not read yet
    std::vector<types::ImuSample> imu;
    std::vector<types::OrientationSample> ahrs;
    std::vector<types::PressureSample> pressure;
    types::Trajectory ground_truth;
    types::OutsidePositions outside;
    std::vector<KnownDistance> known_distances;
    std::optional<MarkerPlan> markers;
};

// Reads the contents of a dive, all but its frames; missing and invalid data are reported as
// findings.
DiveContents read_contents(const DiveFiles& files, const DiveLimits& limits, FindingLog& findings);

}  // namespace divemesh::dive
