#include "worker/boards/saddle.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace divemesh::boards {
namespace {

constexpr int kMinWindow_px = 2;
constexpr int kMaxWindow_px = 10;

}  // namespace

bool move_to_saddle(const cv::Mat& image, double half_px, cv::Point2f& point) {
    const int window_px = std::clamp(static_cast<int>(half_px), kMinWindow_px, kMaxWindow_px);
    const auto border = static_cast<float>(window_px + 2);
    if (point.x < border || point.y < border ||
        point.x > static_cast<float>(image.cols) - 1.0F - border ||
        point.y > static_cast<float>(image.rows) - 1.0F - border)
        return false;
    std::vector<cv::Point2f> points = {point};
    cv::cornerSubPix(image,
                     points,
                     {window_px, window_px},
                     {-1, -1},
                     {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 50, 1e-4});
    const cv::Point2f moved = points[0] - point;
    if (std::hypot(moved.x, moved.y) > static_cast<float>(window_px)) return false;
    point = points[0];
    return true;
}

}  // namespace divemesh::boards
