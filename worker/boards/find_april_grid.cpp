#include "worker/boards/find_april_grid.hpp"

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>

#include "worker/boards/saddle.hpp"
#include "worker/markers/find_tags.hpp"

namespace divemesh::boards {
namespace {

constexpr double kSearchWidth_px = 2000.0;  // wider images are searched at a smaller size
constexpr int kNumMoreCells = 1;      // Kalibr prints a border of two cells, the family has one
constexpr double kBorderShare = 0.2;  // that border over the edge of a tag of ten cells
constexpr double kWindowShare = 0.6;  // of the border or the gap: no other edge is so near
// Black squares touch the corners of the tags. White that grows by 1 to 4 px parts them: by how
// much depends on how sharp and how large they are.
constexpr int kKernels_px[] = {3, 2, 5};

Eigen::Vector2d center_px(const markers::Tag& tag) {
    return 0.25 * (tag.corners_px[0] + tag.corners_px[1] + tag.corners_px[2] + tag.corners_px[3]);
}

double edge_px(const markers::Tag& tag) {
    double shortest = (tag.corners_px[3] - tag.corners_px[0]).norm();
    for (std::size_t k = 0; k + 1 < dive::kNumTagCorners; ++k)
        shortest = std::min(shortest, (tag.corners_px[k + 1] - tag.corners_px[k]).norm());
    return shortest;
}

// Returns the tag where it was before white grew by `kernel_px` - 1 in all and before the image
// was made smaller.
markers::Tag as_recorded(markers::Tag tag, int kernel_px, double scale) {
    const double half_px = 0.5 * (kernel_px - 1);
    const Eigen::Vector2d shift(kernel_px % 2 == 0 ? 0.5 : 0.0, kernel_px % 2 == 0 ? 0.5 : 0.0);
    const Eigen::Vector2d center = center_px(tag);
    const double growth = 1.0 + 2.0 * half_px / std::max(1.0, edge_px(tag));
    for (Eigen::Vector2d& corner : tag.corners_px) {
        corner = center + growth * (corner - center) - shift;
        corner = ((corner.array() + 0.5) / scale - 0.5).matrix();
    }
    return tag;
}

// Returns the tags of the board by number; without those that are seen in two places, of which
// one is not of the board.
std::map<int, markers::Tag> find_grid_tags(const cv::Mat& image, const Board& board) {
    const double scale = std::min(1.0, kSearchWidth_px / image.cols);
    cv::Mat searched = image;
    if (scale < 1.0) cv::resize(image, searched, {}, scale, scale, cv::INTER_AREA);
    std::map<int, markers::Tag> tags;
    std::set<int> repeated;
    for (const int kernel_px : kKernels_px) {
        cv::Mat parted;
        cv::dilate(searched, parted, cv::Mat::ones(kernel_px, kernel_px, CV_8UC1));
        for (const markers::Tag& found :
             markers::find_wide_tags(parted, dive::MarkerFamily::Tag36h11, kNumMoreCells)) {
            if (found.id >= board.num_columns * board.num_rows) continue;
            const markers::Tag tag = as_recorded(found, kernel_px, scale);
            const auto known = tags.emplace(tag.id, tag).first;
            if ((center_px(known->second) - center_px(tag)).norm() > 0.5 * edge_px(tag))
                repeated.insert(tag.id);
        }
    }
    for (const int id : repeated) tags.erase(id);
    return tags;
}

// Returns the number of a tag's corner in the grid: the first tag is at the lower left.
int grid_corner(const Board& board, int tag, std::size_t tag_corner) {
    const bool is_right = tag_corner == 1 || tag_corner == 2;
    const bool is_upper = tag_corner >= 2;
    const int column = 2 * (tag % board.num_columns) + (is_right ? 1 : 0);
    const int row = 2 * (tag / board.num_columns) + (is_upper ? 1 : 0);
    return row * board.num_corner_columns() + column;
}

}  // namespace

BoardCorners find_april_grid(const cv::Mat& image, const Board& board) {
    const double gap = board.column_step_m / board.tag_size_m - 1.0;
    BoardCorners corners;
    for (const auto& [id, tag] : find_grid_tags(image, board)) {
        const double window_px = kWindowShare * std::min(gap, kBorderShare) * edge_px(tag);
        for (std::size_t k = 0; k < dive::kNumTagCorners; ++k) {
            cv::Point2f point(static_cast<float>(tag.corners_px[k].x()),
                              static_cast<float>(tag.corners_px[k].y()));
            if (!move_to_saddle(image, window_px, point)) continue;
            corners.push_back({grid_corner(board, id, k), {point.x, point.y}});
        }
    }
    std::sort(corners.begin(), corners.end(), [](const BoardCorner& a, const BoardCorner& b) {
        return a.corner < b.corner;
    });
    return corners;
}

}  // namespace divemesh::boards
