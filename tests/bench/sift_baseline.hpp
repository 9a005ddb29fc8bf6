#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::bench {

// A sequence of linked frames, with poses in the frame of the first left camera.
struct SiftChain {
    types::Trajectory T_first_cam0;
};

// The path that OpenCV estimates from frame to frame.
struct SiftPath {
    int num_frames = 0;
    int num_links = 0;              // frames linked to the frame before
    std::vector<SiftChain> chains;  // a new one begins where a link is missing

    double linked_share() const;       // links found, of all pairs of neighbours, 0 to 1
    const SiftChain* longest() const;  // nullptr without frames
};

// Returns the path of a baseline made of a few OpenCV calls. It matches SIFT features with Lowe's
// ratio test between left and right image, near epipolar lines, and with the previous frame, and
// runs solvePnPRansac on the previous frame's points. It uses no IMU, no map and no loops.
SiftPath sift_path(types::Recording& dive);

}  // namespace divemesh::bench
