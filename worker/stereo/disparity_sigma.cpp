#include "worker/stereo/disparity_sigma.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "worker/stereo/running_sums.hpp"
#include "worker/stereo/sigma_limits.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kWindow_px = 7;
constexpr double kMinNoise = 0.5;  // grey values: quantisation and a bit more
constexpr double kMaxNoise = 8.0;  // more than that is texture
// Darker and brighter pixels are clipped and show no noise: the surround of a fisheye image, water
// out of reach of the lamps.
constexpr int kMinGrey = 3;
constexpr int kMaxGrey = 252;

struct Noise {
    float energy;
    float scale;
};

// Computes sigma from the sums of the gradient and of its square over a window.
DIVEMESH_INLINE_BODY void rate_texture(const float* __restrict gradient,
                                       const float* __restrict energy,
                                       Noise noise,
                                       int num,
                                       float* __restrict sigma) {
    constexpr float kNum = kWindow_px * kWindow_px;
    for (int x = kWindow_px / 2; x < num - kWindow_px / 2; ++x) {
        const float texture = energy[x] - gradient[x] * gradient[x] / kNum - noise.energy;
        const float known = noise.scale / std::sqrt(std::max(texture, 1.0F));
        const float floored = known > kMinSigma_px ? known : kMinSigma_px;
        sigma[x] = texture > 0.5F * noise.energy ? floored : std::numeric_limits<float>::infinity();
    }
}

}  // namespace

double image_noise(const cv::Mat& image) {
    // [1 -2 1; -2 4 -2; 1 -2 1] turns white noise of standard deviation s into 6 s.
    std::array<std::int64_t, 2048> histogram{};
    std::int64_t num = 0;
    for (int y = 1; y + 1 < image.rows; y += 2) {
        const std::uint8_t* a = image.ptr<std::uint8_t>(y - 1);
        const std::uint8_t* b = image.ptr<std::uint8_t>(y);
        const std::uint8_t* c = image.ptr<std::uint8_t>(y + 1);
        for (int x = 1; x + 1 < image.cols; x += 2) {
            if (b[x] < kMinGrey || b[x] > kMaxGrey) continue;
            const int second = a[x - 1] - 2 * a[x] + a[x + 1] - 2 * b[x - 1] + 4 * b[x] -
                               2 * b[x + 1] + c[x - 1] - 2 * c[x] + c[x + 1];
            ++histogram[std::min(std::abs(second), 2047)];
            ++num;
        }
    }
    if (num == 0) return kMinNoise;
    // The lower quartile of |N(0, 6 s)| is 0.3186 * 6 s.
    const std::int64_t quarter = num / 4;
    std::int64_t below = 0;
    int quantile = 0;
    while (quantile < 2047 && below + histogram[quantile] <= quarter)
        below += histogram[quantile++];
    return std::clamp(quantile / (6.0 * 0.3186), kMinNoise, kMaxNoise);
}

cv::Mat disparity_sigma(const cv::Mat& image, base::Instructions instructions) {
    const double noise = image_noise(image);
    constexpr float kNum = kWindow_px * kWindow_px;
    // The gradient is stored times two.
    const auto noise_energy = static_cast<float>(4.0 * kNum * noise * noise / 2.0);
    const auto scale = static_cast<float>(2.0 * std::sqrt(2.0) * noise);
    const auto rate = base::compiled_for<rate_texture>(instructions);
    cv::Mat sigma(image.size(), CV_32F, cv::Scalar(std::numeric_limits<double>::infinity()));
    RunningSums window(2, image.cols, kWindow_px / 2, instructions);
    for (int y = 0; y < image.rows; ++y) {
        const std::uint8_t* in = image.ptr<std::uint8_t>(y);
        std::int32_t* gradient = window.next(0).data();
        std::int32_t* energy = window.next(1).data();
        for (int x = 1; x + 1 < image.cols; ++x) {
            gradient[x] = in[x + 1] - in[x - 1];
            energy[x] = gradient[x] * gradient[x];
        }
        window.add_row();
        if (!window.whole()) continue;
        rate(window.sums(0).data(),
             window.sums(1).data(),
             {noise_energy, scale},
             image.cols,
             sigma.ptr<float>(y - kWindow_px / 2));
    }
    return sigma;
}

}  // namespace divemesh::stereo
