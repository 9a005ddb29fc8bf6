#pragma once

#include <Eigen/Core>
#include <vector>

namespace divemesh::types {

// A point of the scene as found in both rectified images of a pair. In a pair whose calibration is
// not right the two may lie on different rows.
struct StereoMatch {
    int frame_index = 0;
    Eigen::Vector2d left_px = Eigen::Vector2d::Zero();
    Eigen::Vector2d right_px = Eigen::Vector2d::Zero();
};
using StereoMatches = std::vector<StereoMatch>;

}  // namespace divemesh::types
