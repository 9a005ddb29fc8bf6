#include "worker/stereo/disparity_sigma.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace divemesh::worker {
namespace {

constexpr int kWindow_px = 7;
constexpr double kLeastNoise = 0.5;    // grey values: quantisation and a little
constexpr double kLargestNoise = 8.0;  // more than that is texture
constexpr float kFloor_px = 0.15F;     // what calibration, interpolation and slant leave

}  // namespace

double image_noise(const cv::Mat& image) {
    // [1 -2 1; -2 4 -2; 1 -2 1] turns white noise of deviation s into one of 6 s.
    std::array<std::int64_t, 2048> histogram{};
    std::int64_t num = 0;
    for (int y = 1; y + 1 < image.rows; y += 2) {
        const std::uint8_t* a = image.ptr<std::uint8_t>(y - 1);
        const std::uint8_t* b = image.ptr<std::uint8_t>(y);
        const std::uint8_t* c = image.ptr<std::uint8_t>(y + 1);
        for (int x = 1; x + 1 < image.cols; x += 2, ++num) {
            const int second = a[x - 1] - 2 * a[x] + a[x + 1] - 2 * b[x - 1] + 4 * b[x] -
                               2 * b[x + 1] + c[x - 1] - 2 * c[x] + c[x + 1];
            ++histogram[std::min(std::abs(second), 2047)];
        }
    }
    // The lower quartile of |N(0, 6 s)| is 0.3186 * 6 s.
    const std::int64_t quarter = num / 4;
    std::int64_t below = 0;
    int quantile = 0;
    while (quantile < 2047 && below + histogram[quantile] <= quarter)
        below += histogram[quantile++];
    return std::clamp(quantile / (6.0 * 0.3186), kLeastNoise, kLargestNoise);
}

cv::Mat disparity_sigma(const cv::Mat& image) {
    const double noise = image_noise(image);
    cv::Mat gradient(image.size(), CV_32F, cv::Scalar(0.0));
    for (int y = 0; y < image.rows; ++y) {
        const std::uint8_t* in = image.ptr<std::uint8_t>(y);
        float* out = gradient.ptr<float>(y);
        for (int x = 1; x + 1 < image.cols; ++x)
            out[x] = 0.5F * static_cast<float>(in[x + 1] - in[x - 1]);
    }
    cv::Mat energy, sum;
    const cv::Size window(kWindow_px, kWindow_px);
    cv::sqrBoxFilter(gradient, energy, CV_32F, window, cv::Point(-1, -1), false);
    cv::boxFilter(gradient, sum, CV_32F, window, cv::Point(-1, -1), false);
    constexpr float kNum = kWindow_px * kWindow_px;
    const auto noise_energy = static_cast<float>(kNum * noise * noise / 2.0);
    const auto scale = static_cast<float>(std::sqrt(2.0) * noise);
    cv::Mat sigma(image.size(), CV_32F);
    for (int y = 0; y < image.rows; ++y) {
        const float* e = energy.ptr<float>(y);
        const float* s = sum.ptr<float>(y);
        float* out = sigma.ptr<float>(y);
        for (int x = 0; x < image.cols; ++x) {
            const float texture = e[x] - s[x] * s[x] / kNum - noise_energy;
            out[x] = texture > 0.5F * noise_energy ? std::max(kFloor_px, scale / std::sqrt(texture))
                                                   : std::numeric_limits<float>::infinity();
        }
    }
    return sigma;
}

}  // namespace divemesh::worker
