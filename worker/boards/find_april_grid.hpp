#pragma once

#include "worker/boards/find_board.hpp"

namespace divemesh::boards {

// Returns the corners of the tags of an AprilGrid that are in sight, as find_board() does.
BoardCorners find_april_grid(const cv::Mat& image, const Board& board);

}  // namespace divemesh::boards
