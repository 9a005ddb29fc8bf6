#include "worker/stereo/disparity_doubt.hpp"

#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace divemesh::stereo {
namespace {

constexpr int kWindow_px = 9;          // as wide as the windows of matching and refinement
constexpr float kMaxStep_px = 3.0F;    // within 3 x 3 pixels of one surface
constexpr float kFullDoubt_px = 2.5F;  // sigma where all winners around are doubtful

}  // namespace

void add_doubt(const cv::Mat& winners_px, cv::Mat& sigma_px) {
    const cv::Mat size = cv::abs(winners_px);
    cv::Mat min_px, max_px, num_doubtful;
    cv::erode(size, min_px, {});
    cv::dilate(size, max_px, {});
    cv::Mat doubtful = (max_px - min_px > kMaxStep_px) | (winners_px <= 0.0F);
    cv::boxFilter(doubtful / 255, num_doubtful, CV_32F, {kWindow_px, kWindow_px}, {-1, -1}, false);
    constexpr float kPerPixel = kFullDoubt_px / static_cast<float>(kWindow_px * kWindow_px);
    for (int y = 0; y < sigma_px.rows; ++y) {
        const float* num = num_doubtful.ptr<float>(y);
        float* sigma = sigma_px.ptr<float>(y);
        for (int x = 0; x < sigma_px.cols; ++x) {
            const float doubt = kPerPixel * num[x];
            sigma[x] = std::sqrt(sigma[x] * sigma[x] + doubt * doubt);
        }
    }
}

}  // namespace divemesh::stereo
