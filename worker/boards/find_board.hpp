#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/boards/board.hpp"

namespace divemesh::boards {

// A corner of a board in an image; pixel centres at integers.
struct BoardCorner {
    int corner = 0;  // see Board
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};
using BoardCorners = std::vector<BoardCorner>;  // by rising corner, each at most once

// Returns the corners of a board in a grey image as recorded; empty if it is not seen. A
// checkerboard is seen in whole or not at all (A. Duda and U. Frese, "Accurate detection and
// localization of checkerboard corners", BMVC 2018, as OpenCV has it); of an AprilGrid each tag
// counts. The same image gives the same corners in any thread. Thread-safe.
BoardCorners find_board(const cv::Mat& image, const Board& board);

// Numbers the corners of a checkerboard in the right image as in the left one: turned by 180
// degrees a checkerboard looks the same, if it is square by 90 as well. Both cameras have to be
// upright, or turned alike.
BoardCorners numbered_alike(const BoardCorners& left, BoardCorners right, const Board& board);

}  // namespace divemesh::boards
