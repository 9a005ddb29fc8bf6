#include "worker/features/high_pass.hpp"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace divemesh::features {
namespace {

constexpr int kBlock_px = 15;  // about a patch: wider structures are no features
constexpr int kMiddle = 128;

void subtract_row(const std::uint8_t* __restrict image,
                  const std::uint8_t* __restrict mean,
                  int width,
                  std::uint8_t* __restrict result) {
    for (int u = 0; u < width; ++u)
        result[u] = static_cast<std::uint8_t>(std::clamp(kMiddle + image[u] - mean[u], 0, 255));
}

}  // namespace

void HighPass::apply(const cv::Mat& image, cv::Mat& result) {
    cv::blur(image, mean_, cv::Size(kBlock_px, kBlock_px));
    result.create(image.size(), CV_8UC1);
    for (int v = 0; v < image.rows; ++v)
        subtract_row(image.ptr<std::uint8_t>(v),
                     mean_.ptr<std::uint8_t>(v),
                     image.cols,
                     result.ptr<std::uint8_t>(v));
}

}  // namespace divemesh::features
