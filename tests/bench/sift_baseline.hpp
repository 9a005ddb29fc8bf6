#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::bench {

// Frames that are linked one to the next, with poses in the frame of their first left camera.
struct SiftChain {
    types::Trajectory T_first_cam0;
};

// The path that OpenCV finds from frame to frame.
struct SiftPath {
    int num_frames = 0;
    int num_links = 0;              // of frames with the frame before
    std::vector<SiftChain> chains;  // parted where a link is missing

    double linked_share() const;       // of all links between neighbours, 0 to 1
    const SiftChain* longest() const;  // null: no frame
};

// What a few lines of OpenCV make of a dive: SIFT in both images, matched with Lowe's ratio between
// the eyes, along epipolar lines, and to the frame before; solvePnPRansac from the points of the
// frame before. No IMU, no map, no loops.
SiftPath sift_path(types::Recording& dive);

}  // namespace divemesh::bench
