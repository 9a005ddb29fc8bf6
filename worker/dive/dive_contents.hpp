#pragma once

#include <vector>

#include "worker/dive/dive.hpp"
#include "worker/dive/dive_files.hpp"
#include "worker/dive/frame_list.hpp"

namespace divemesh::worker {

// Everything of a dive but its pictures, in the frames of Rig.
struct DiveContents {
    DiveInfo info;
    Rig rig;
    bool has_rig = false;  // both cameras are calibrated
    std::vector<FramePair> pairs;
    std::vector<ImuSample> imu;
    std::vector<OrientationSample> ahrs;
    std::vector<PressureSample> pressure;
    Trajectory ground_truth;
    std::vector<KnownDistance> known_distances;
    std::optional<MarkerPlan> markers;
};

// What is missing or wrong is a finding.
DiveContents read_contents(const DiveFiles& files, const DiveLimits& limits, FindingLog& findings);

}  // namespace divemesh::worker
