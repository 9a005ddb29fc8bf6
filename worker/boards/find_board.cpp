#include "worker/boards/find_board.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "worker/boards/find_april_grid.hpp"
#include "worker/boards/saddle.hpp"

namespace divemesh::boards {
namespace {

constexpr double kSearchWidth_px =
    1000.0;                           // wider images are searched at a smaller size: 10 x faster
constexpr int kMinSide_px = 32;       // smaller images hold no board that can be told
constexpr double kWindowShare = 0.3;  // of the distance to the next corner

// Returns the distance from a corner to the nearest of its neighbours in the grid.
double nearest_px(const std::vector<cv::Point2f>& points, int corner, const Board& board) {
    const int columns = board.num_columns;
    const int column = corner % columns;
    const int row = corner / columns;
    double nearest = std::numeric_limits<double>::max();
    for (const auto& [dx, dy] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
        if (column + dx < 0 || column + dx >= columns) continue;
        if (row + dy < 0 || row + dy >= board.num_rows) continue;
        const cv::Point2f step = points[static_cast<std::size_t>(corner + dx + dy * columns)] -
                                 points[static_cast<std::size_t>(corner)];
        nearest = std::min(nearest, static_cast<double>(std::hypot(step.x, step.y)));
    }
    return nearest;
}

// Returns the board as the camera sees its face, not mirrored: x to y is clockwise in the image.
void unmirror(std::vector<cv::Point2f>& points, const Board& board) {
    const auto columns = static_cast<std::ptrdiff_t>(board.num_columns);
    const cv::Point2f along_row = points[static_cast<std::size_t>(columns - 1)] - points.front();
    const cv::Point2f along_column =
        points[points.size() - static_cast<std::size_t>(columns)] - points.front();
    if (along_row.cross(along_column) >= 0.0F) return;
    for (auto row = points.begin(); row != points.end(); row += columns)
        std::reverse(row, row + columns);
}

BoardCorners find_checkerboard(const cv::Mat& image, const Board& board) {
    cv::theRNG().state = 1;  // the search draws from the thread's random numbers
    const double scale = std::min(1.0, kSearchWidth_px / image.cols);
    cv::Mat searched = image;
    if (scale < 1.0) cv::resize(image, searched, {}, scale, scale, cv::INTER_AREA);
    std::vector<cv::Point2f> points;
    if (!cv::findChessboardCornersSB(searched,
                                     {board.num_columns, board.num_rows},
                                     points,
                                     cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE) ||
        static_cast<int>(points.size()) != board.num_corners())
        return {};
    for (cv::Point2f& point : points) {
        point.x = (point.x + 0.5F) / static_cast<float>(scale) - 0.5F;
        point.y = (point.y + 0.5F) / static_cast<float>(scale) - 0.5F;
    }
    unmirror(points, board);
    const std::vector<cv::Point2f> found = points;
    BoardCorners corners;
    for (int i = 0; i < board.num_corners(); ++i) {
        cv::Point2f& point = points[static_cast<std::size_t>(i)];
        if (!move_to_saddle(image, kWindowShare * nearest_px(found, i, board), point)) continue;
        corners.push_back({i, {point.x, point.y}});
    }
    return corners;
}

// Returns the number of a corner on the board turned by 90 degrees `num_quarters` times.
int turned(int corner, int num_quarters, const Board& board) {
    int column = corner % board.num_columns;
    int row = corner / board.num_columns;
    int columns = board.num_columns;
    int rows = board.num_rows;
    for (int i = 0; i < num_quarters; ++i) {
        const int before = column;
        column = rows - 1 - row;
        row = before;
        std::swap(columns, rows);
    }
    return row * columns + column;
}

// Returns how much both images differ in where corners of a number are, around their centres.
double difference_px2(const BoardCorners& left, const BoardCorners& right) {
    std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> common;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (std::size_t i = 0, j = 0; i < left.size() && j < right.size();) {
        if (left[i].corner == right[j].corner) {
            common.emplace_back(left[i].pixel, right[j].pixel);
            mean += right[j].pixel - left[i].pixel;
        }
        left[i].corner <= right[j].corner ? ++i : ++j;
    }
    if (common.empty()) return std::numeric_limits<double>::max();
    mean /= static_cast<double>(common.size());
    double sum = 0.0;
    for (const auto& [a, b] : common) sum += (b - a - mean).squaredNorm();
    return sum / static_cast<double>(common.size());
}

}  // namespace

BoardCorners find_board(const cv::Mat& image, const Board& board) {
    if (std::min(image.cols, image.rows) < kMinSide_px) return {};
    return board.kind == BoardKind::Checkerboard ? find_checkerboard(image, board)
                                                 : find_april_grid(image, board);
}

BoardCorners numbered_alike(const BoardCorners& left, BoardCorners right, const Board& board) {
    if (board.kind != BoardKind::Checkerboard || left.empty() || right.empty()) return right;
    const bool is_square = board.num_columns == board.num_rows;
    BoardCorners best = right;
    for (int quarters = is_square ? 1 : 2; quarters < 4; quarters += is_square ? 1 : 2) {
        BoardCorners other = right;
        for (BoardCorner& corner : other) corner.corner = turned(corner.corner, quarters, board);
        std::sort(other.begin(), other.end(), [](const BoardCorner& a, const BoardCorner& b) {
            return a.corner < b.corner;
        });
        if (difference_px2(left, other) < difference_px2(left, best)) best = std::move(other);
    }
    return best;
}

}  // namespace divemesh::boards
