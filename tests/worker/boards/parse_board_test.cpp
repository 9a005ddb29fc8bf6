#include <gtest/gtest.h>

#include <string>

#include "schemas/error.hpp"
#include "worker/boards/board.hpp"

namespace divemesh::boards {
namespace {

// Examples of Kalibr's own documentation.
constexpr const char* kCheckerboard =
    "target_type: 'checkerboard' #gridtype\n"
    "targetCols: 6               #number of internal chessboard corners\n"
    "targetRows: 7               #number of internal chessboard corners\n"
    "rowSpacingMeters: 0.06      #size of one chessboard square [m]\n"
    "colSpacingMeters: 0.05      #size of one chessboard square [m]\n";
constexpr const char* kAprilGrid =
    "target_type: 'aprilgrid' #gridtype\n"
    "tagCols: 6               #number of apriltags\n"
    "tagRows: 5               #number of apriltags\n"
    "tagSize: 0.088           #size of apriltag, edge to edge [m]\n"
    "tagSpacing: 0.3          #ratio of space between tags to tagSize\n";

std::string with(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
}

std::string refusal_of(const std::string& text) {
    try {
        parse_board(text, "board.yaml");
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::BadData);
        return error.what();
    }
    return "";
}

TEST(ParseBoardTest, ReadsKalibrsCheckerboard) {
    const Board board = parse_board(kCheckerboard, "board.yaml");
    EXPECT_EQ(board.num_corners(), 42);
    EXPECT_EQ(board.corner_m(7), Eigen::Vector3d(0.05, 0.06, 0.0));
    EXPECT_NEAR((board.corner_m(41) - Eigen::Vector3d(0.25, 0.36, 0.0)).norm(), 0.0, 1e-12);
}

TEST(ParseBoardTest, ReadsKalibrsAprilGrid) {
    const Board board = parse_board(kAprilGrid, "board.yaml");
    EXPECT_EQ(board.num_corners(), 120);
    EXPECT_NEAR(board.corner_m(1).x(), 0.088, 1e-12);        // the other edge of the first tag
    EXPECT_NEAR(board.corner_m(2).x(), 1.3 * 0.088, 1e-12);  // the next tag
    EXPECT_NEAR(board.corner_m(24).y(), 1.3 * 0.088, 1e-12);
}

TEST(ParseBoardTest, SaysWhichKindsAreRead) {
    EXPECT_NE(refusal_of("target_type: 'charuco'\n").find("ChArUco and grids of circles are not"),
              std::string::npos);
    EXPECT_NE(refusal_of("tagCols: 3\n").find("target_type is missing"), std::string::npos);
}

TEST(ParseBoardTest, RefusesCountsAndSizesThatNoBoardHas) {
    for (const char* value : {"2", "-6", "0", "6.5", "51", "1e300", ".nan", ".inf", "six", "[6]"})
        EXPECT_NE(
            refusal_of(with(kCheckerboard, "targetCols: 6", "targetCols: " + std::string(value)))
                .find("board.yaml: targetCols"),
            std::string::npos)
            << value;
    for (const char* value : {"0", "-0.06", "60", ".nan", "1e-9", "''"})
        EXPECT_NE(refusal_of(with(kCheckerboard,
                                  "rowSpacingMeters: 0.06",
                                  "rowSpacingMeters: " + std::string(value)))
                      .find("rowSpacingMeters"),
                  std::string::npos)
            << value;
    EXPECT_NE(
        refusal_of(with(with(kAprilGrid, "tagCols: 6", "tagCols: 25"), "tagRows: 5", "tagRows: 25"))
            .find("587"),
        std::string::npos);
    EXPECT_NE(refusal_of(with(kAprilGrid, "tagSpacing: 0.3", "tagSpacing: -1")).find("tagSpacing"),
              std::string::npos);
}

TEST(ParseBoardTest, RefusesWhatIsNoTargetFile) {
    const std::string nested(100, '[');
    for (const std::string& text : {std::string(),
                                    std::string("- 1\n- 2\n"),
                                    nested,
                                    std::string("a: &x [1]\nb: *x\n"),
                                    std::string("\0\1\2", 3)})
        EXPECT_NE(refusal_of(text), "") << text;
}

}  // namespace
}  // namespace divemesh::boards
