#include "worker/camera/view_details.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace divemesh::camera {
namespace {

constexpr int kWidth_px = 160;
constexpr double kCoarse_px = 3.0;  // of a Gaussian
const cv::Size kCells(8, 6);
constexpr double kMinContrast = 1.0;  // grey values, RMS of the details of a cell
// Images at rest have 0.33 and more under strong caustics, and nearly 1 without; of a moving rig 0
// is usual, and 0.26 where a car looks straight ahead.
constexpr double kMinNcc = 0.3;

}  // namespace

cv::Mat small_view(const cv::Mat& image) {
    cv::Mat values;
    image.convertTo(values, CV_32F);
    const double reduction = std::min(1.0, static_cast<double>(kWidth_px) / image.cols);
    cv::Mat small;
    cv::resize(values, small, {}, reduction, reduction, cv::INTER_AREA);
    return small;
}

cv::Mat view_details(const cv::Mat& small_view) {
    cv::Mat coarse;
    cv::GaussianBlur(small_view, coarse, {}, kCoarse_px);
    return small_view - coarse;
}

bool is_same_view(const cv::Mat& first_details, const cv::Mat& second_details) {
    const cv::Size size = first_details.size();
    int num_compared = 0;
    int num_alike = 0;
    for (int row = 0; row < kCells.height; ++row)
        for (int column = 0; column < kCells.width; ++column) {
            const cv::Rect cell(
                cv::Point(size.width * column / kCells.width, size.height * row / kCells.height),
                cv::Point(size.width * (column + 1) / kCells.width,
                          size.height * (row + 1) / kCells.height));
            const cv::Mat first = first_details(cell);
            const cv::Mat second = second_details(cell);
            const double min_norm = kMinContrast * std::sqrt(static_cast<double>(cell.area()));
            const double first_norm = cv::norm(first);
            const double second_norm = cv::norm(second);
            if (first_norm < min_norm && second_norm < min_norm) continue;
            ++num_compared;
            if (first.dot(second) > kMinNcc * first_norm * second_norm) ++num_alike;
        }
    return num_compared == 0 || 2 * num_alike > num_compared;
}

}  // namespace divemesh::camera
