#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/dive/marker_plan.hpp"
#include "worker/markers/tag_layout.hpp"

namespace divemesh::markers {

// A tag in one image; corners in the order of TagCorner, pixel centres at integers.
struct Tag {
    int id = 0;
    std::array<Eigen::Vector2d, dive::kNumTagCorners> corners_px;
};

// Returns the tags of a family in a grey image without lens distortion, by rising id (AprilTag 3:
// Wang and Olson, IROS 2016), with corners refined by refine_corners. Candidates that need a bit
// correction are rejected. Runs in the caller's thread; thread-safe.
std::vector<Tag> find_tags(const cv::Mat& image, dive::MarkerFamily family);

// Returns the tags of a family that are printed with `num_more_cells` more cells of black around
// them, as above; corners are those of the whole black square, as the library finds them.
std::vector<Tag> find_wide_tags(const cv::Mat& image,
                                dive::MarkerFamily family,
                                int num_more_cells);

// Fits a line to each edge, where brightness changes most across it (weighted centres of the
// gradient over half a cell to both sides), and moves the corners to the intersections of the
// lines. Edges that cannot be fitted (shorter than 12 px, or lost in noise) leave the tag as it is.
void refine_corners(const cv::Mat& image, const TagLayout& layout, Tag& tag);

}  // namespace divemesh::markers
