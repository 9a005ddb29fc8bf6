#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/dive/marker_family.hpp"

namespace divemesh::markers {

// How a tag is laid out: a square of `total_cells` cells, in the middle of which lies the square
// whose edge is the tag's size. Its edge is where black meets white: black within, or white within.
struct TagLayout {
    int total_cells = 0;
    int size_cells = 0;
    bool white_within = false;
};
TagLayout tag_layout(dive::MarkerFamily family);

// One pixel a cell, CV_8UC1, 0 and 255. Throws Error{InvalidArgument} for an id that there is not.
cv::Mat tag_image(dive::MarkerFamily family, int id);

}  // namespace divemesh::markers
