#include "worker/boards/find_board.hpp"

#include <gtest/gtest.h>

#include "tests/worker/board_calibration/synthetic_boards.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/camera/projection.hpp"

namespace divemesh::board_calibration {
namespace {

boards::Board april_grid() {
    boards::Board board;
    board.kind = boards::BoardKind::AprilGrid;
    board.num_columns = 3;
    board.num_rows = 2;
    board.tag_size_m = 0.1;
    board.column_step_m = board.row_step_m = 0.13;
    return board;
}

Eigen::Isometry3d tilted_pose(const boards::Board& board) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = base::rotation_from_vector({0.3, -0.25, 0.1}).toRotationMatrix();
    if (board.kind == boards::BoardKind::AprilGrid)
        T.linear() = T.linear() * Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
    T.translation() = Eigen::Vector3d(0.03, -0.02, 0.6) - T.linear() * board.center_m();
    return T;
}

// Returns the RMS over both axes of where corners are found.
double rms_px(const boards::Board& board, types::Distortion distortion) {
    const types::Camera camera = known_rig(distortion).cam0();
    const Eigen::Isometry3d T = tilted_pose(board);
    boards::BoardCorners truth;
    for (int i = 0; i < board.num_corners(); ++i)
        truth.push_back({i, *camera::project(camera, T * board.corner_m(i))});
    // Turned by 180 degrees this checkerboard looks the same.
    const auto corners = boards::numbered_alike(
        truth, boards::find_board(rendered_board(ImageRays(camera), board, T), board), board);
    EXPECT_EQ(static_cast<int>(corners.size()), board.num_corners());
    double squares = 0.0;
    for (const boards::BoardCorner& corner : corners)
        squares += (*camera::project(camera, T * board.corner_m(corner.corner)) - corner.pixel)
                       .squaredNorm();
    return std::sqrt(squares / (2.0 * static_cast<double>(corners.size())));
}

TEST(FindBoardTest, FindsTheCornersOfACheckerboardToAFewHundredthsOfAPixel) {
    EXPECT_LT(rms_px(known_checkerboard(), types::Distortion::RadialTangential), 0.05);
}

TEST(FindBoardTest, FindsTheCornersOfAnAprilGridToAFewHundredthsOfAPixel) {
    EXPECT_LT(rms_px(april_grid(), types::Distortion::RadialTangential), 0.05);
    EXPECT_LT(rms_px(april_grid(), types::Distortion::Equidistant), 0.1);
}

TEST(FindBoardTest, FindsNothingOnAnEmptyImage) {
    const cv::Mat grey(480, 640, CV_8UC1, cv::Scalar(120));
    EXPECT_TRUE(boards::find_board(grey, known_checkerboard()).empty());
    EXPECT_TRUE(boards::find_board(grey, april_grid()).empty());
    const cv::Mat tiny(2, 3, CV_8UC1, cv::Scalar(120));
    EXPECT_TRUE(boards::find_board(tiny, known_checkerboard()).empty());
}

TEST(FindBoardTest, NumbersARightImageThatStartsAtTheOtherEndAlike) {
    const boards::Board board = known_checkerboard();
    boards::BoardCorners left;
    boards::BoardCorners turned;
    for (int i = 0; i < board.num_corners(); ++i) {
        const Eigen::Vector2d pixel = 1000.0 * board.corner_m(i).head<2>();
        left.push_back({i, pixel});
        turned.insert(turned.begin(),
                      {board.num_corners() - 1 - i, pixel - Eigen::Vector2d(40.0, 1.0)});
    }
    const auto right = boards::numbered_alike(left, turned, board);
    ASSERT_EQ(right.size(), left.size());
    for (std::size_t i = 0; i < right.size(); ++i) {
        EXPECT_EQ(right[i].corner, left[i].corner);
        EXPECT_EQ(right[i].pixel, left[i].pixel - Eigen::Vector2d(40.0, 1.0));
    }
}

}  // namespace
}  // namespace divemesh::board_calibration
