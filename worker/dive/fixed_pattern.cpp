#include "worker/dive/fixed_pattern.hpp"

#include <opencv2/imgproc.hpp>

namespace divemesh::dive {
namespace {

constexpr int kMinImages = 6;
constexpr double kStill = 4.0;           // grey values; standard deviation over time
constexpr double kEdge = 8.0;            // grey values a px
constexpr double kMinEdgeShare = 0.003;  // of the image; moving scenes have up to 0.0009
constexpr double kMaxStillShare = 0.5;   // of the image; the rig stands still
constexpr int kReach_px = 25;            // letters that change stand this near to fixed edges

}  // namespace

void FixedPattern::add(const cv::Mat& image) {
    cv::Mat values;
    image.convertTo(values, CV_32F);
    if (num_images_++ == 0) {
        sum_ = cv::Mat::zeros(image.size(), CV_32F);
        sum_of_squares_ = cv::Mat::zeros(image.size(), CV_32F);
    }
    sum_ += values;
    sum_of_squares_ += values.mul(values);
}

cv::Mat FixedPattern::mask() const {
    if (num_images_ < kMinImages) return {};
    const cv::Mat mean = sum_ / num_images_;
    const cv::Mat variance = sum_of_squares_ / num_images_ - mean.mul(mean);
    const cv::Mat is_still = variance < kStill * kStill;
    const auto num_pixels = static_cast<double>(mean.total());
    if (cv::countNonZero(is_still) > kMaxStillShare * num_pixels) return {};
    cv::Mat x;
    cv::Mat y;
    cv::Mat slope;
    cv::Sobel(mean, x, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(mean, y, CV_32F, 0, 1, 3, 0.125);
    cv::magnitude(x, y, slope);
    const cv::Mat is_fixed = is_still & (slope > kEdge);
    if (cv::countNonZero(is_fixed) < kMinEdgeShare * num_pixels) return {};
    cv::Mat mask;
    cv::dilate(
        is_fixed, mask, cv::getStructuringElement(cv::MORPH_RECT, {2 * kReach_px + 1, kReach_px}));
    return mask;
}

}  // namespace divemesh::dive
