#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/dive/marker_plan.hpp"

namespace divemesh::markers {

// A tag in one picture; corners in the order of TagCorner, pixel centres at integers.
struct Tag {
    int id = 0;
    std::array<Eigen::Vector2d, dive::kNumTagCorners> corners_px;
};

// The tags of a family in a grey picture without lens distortion, by rising id (AprilTag 3: Wang
// and Olson, IROS 2016); corners as refine_corners has them. What reads as a tag only with a bit
// corrected is none. In the caller's thread alone; any number of threads may call.
std::vector<Tag> find_tags(const cv::Mat& image, dive::MarkerFamily family);

// Each edge is a line fitted to where brightness changes most across it, weighted centres of the
// gradient over half a cell to both sides; corners are where the lines meet. What cannot be fitted
// (edges shorter than 12 px, or lost in noise) stays as it is.
void refine_corners(const cv::Mat& image, const TagLayout& layout, Tag& tag);

}  // namespace divemesh::markers
