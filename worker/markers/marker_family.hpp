#pragma once

#include <opencv2/core/mat.hpp>
#include <string_view>

namespace divemesh::worker {

// The AprilTag families that are looked for (Olson, "AprilTag", ICRA 2011; Krogius, Haggenmiller
// and Olson, "Flexible layouts for fiducial tags", IROS 2019), named as their pictures are.
enum class MarkerFamily { Tag36h11, Tag25h9, TagStandard41h12 };

std::string_view to_string(MarkerFamily family);  // tag36h11, tag25h9, tagStandard41h12
// Also without "tag". Throws Error{InvalidArgument} that lists the families.
MarkerFamily marker_family_from_string(std::string_view text);

// How a tag is laid out: a square of `total_cells` cells, in the middle of which lies the square
// whose edge is the tag's size. Its edge is where black meets white: black within, or white within.
struct TagLayout {
    int total_cells = 0;
    int size_cells = 0;
    bool white_within = false;
    int num_ids = 0;
};
TagLayout tag_layout(MarkerFamily family);

// One pixel a cell, CV_8UC1, 0 and 255. Throws Error{InvalidArgument} for an id that there is not.
cv::Mat tag_picture(MarkerFamily family, int id);

}  // namespace divemesh::worker
