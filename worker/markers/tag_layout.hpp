#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/dive/marker_family.hpp"

namespace divemesh::markers {

// The layout of a tag: a square of `total_cells` cells, with the square whose edge is the tag's
// size in its centre. At that edge black and white meet: white inside or black inside.
struct TagLayout {
    int total_cells = 0;
    int size_cells = 0;
    bool white_within = false;
};
TagLayout tag_layout(dive::MarkerFamily family);

// Returns a tag with one pixel per cell, CV_8UC1, 0 and 255. Throws Error{InvalidArgument} for an
// id outside the family.
cv::Mat tag_image(dive::MarkerFamily family, int id);

}  // namespace divemesh::markers
