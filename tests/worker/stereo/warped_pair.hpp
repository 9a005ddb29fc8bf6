#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <random>
#include <utility>

#include "worker/stats/median.hpp"

namespace divemesh::stereo {

// A rectified pair with exactly known disparity: the right image is a continuous texture, the left
// one is the same texture warped by a disparity given as a function of the left pixel.
struct WarpedPair {
    cv::Mat left;
    cv::Mat right;
    cv::Mat disparity_px;  // CV_32F
};

struct WarpedPairOptions {
    int width_px = 320;
    int height_px = 240;
    double noise = 2.0;  // sigma, grey levels
    double right_gain = 1.0;
    double right_bias = 0.0;
    double contrast = 1.0;
};

// Returns a band-limited texture at several scales from a lattice of pseudo-random values.
inline double texture(double x, double y) {
    const auto lattice = [](std::int64_t i, std::int64_t j) {
        auto h = static_cast<std::uint64_t>(i * 73856093 ^ j * 19349663);
        h ^= h >> 13;
        h *= 0x9E3779B97F4A7C15ULL;
        h ^= h >> 29;
        return static_cast<double>(h & 0xffff) / 65535.0 - 0.5;
    };
    const auto smooth = [](double t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); };
    double sum = 0.0;
    double amplitude = 60.0;
    for (const double scale : {3.0, 6.0, 14.0}) {
        const double u = x / scale + 1000.0, v = y / scale + 1000.0;
        const auto i = static_cast<std::int64_t>(u), j = static_cast<std::int64_t>(v);
        const double a = smooth(u - static_cast<double>(i)), b = smooth(v - static_cast<double>(j));
        sum += amplitude * ((1 - b) * ((1 - a) * lattice(i, j) + a * lattice(i + 1, j)) +
                            b * ((1 - a) * lattice(i, j + 1) + a * lattice(i + 1, j + 1)));
        amplitude *= 1.3;
    }
    return sum;
}

// Returns the pair whose left image is warped by `disparity`, px, with noise in both images.
inline WarpedPair make_warped_pair(const std::function<double(double x, double y)>& disparity,
                                   const WarpedPairOptions& options = {}) {
    const cv::Size size(options.width_px, options.height_px);
    WarpedPair pair{cv::Mat(size, CV_8U), cv::Mat(size, CV_8U), cv::Mat(size, CV_32F)};
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0.0, options.noise);
    const auto grey = [&](double value) { return cv::saturate_cast<std::uint8_t>(value); };
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            const double d = disparity(x, y);
            const double l = options.contrast * texture(x - d, y);
            const double r = options.contrast * texture(x, y);
            pair.disparity_px.at<float>(y, x) = static_cast<float>(d);
            pair.left.at<std::uint8_t>(y, x) = grey(128.0 + l + noise(random));
            pair.right.at<std::uint8_t>(y, x) =
                grey(128.0 + options.right_gain * r + options.right_bias + noise(random));
        }
    return pair;
}

// The error of an estimate, over the pixels where both estimate and truth are known.
struct DisparityError {
    double density = 0.0;  // pixels with an estimate / pixels with truth
    double bad1 = 0.0;     // share of the estimates with an error of more than 1 px
    double median_px = 0.0;
    double mean_px = 0.0;  // signed, over the errors within 1 px
};

// Compares disparities with the truth between 0 and `max_px`, without a border of 8 px.
inline DisparityError compare_disparity(const cv::Mat& estimate,
                                        const cv::Mat& truth,
                                        double max_px) {
    std::vector<double> errors;
    std::int64_t num_truth = 0;
    std::int64_t num_bad = 0;
    double sum = 0.0;
    for (int y = 8; y < truth.rows - 8; ++y)
        for (int x = 8; x < truth.cols - 8; ++x) {
            const double t = truth.at<float>(y, x);
            if (t <= 0.0 || t >= max_px || t > x) continue;
            ++num_truth;
            const double d = estimate.at<float>(y, x);
            if (d <= 0.0) continue;
            errors.push_back(std::abs(d - t));
            if (errors.back() > 1.0)
                ++num_bad;
            else
                sum += d - t;
        }
    DisparityError error;
    if (errors.empty()) return error;
    const auto num = static_cast<double>(errors.size());
    error.density = num / static_cast<double>(num_truth);
    error.bad1 = static_cast<double>(num_bad) / num;
    error.mean_px = sum / (num - static_cast<double>(num_bad));
    error.median_px = stats::upper_median(std::move(errors));
    return error;
}

}  // namespace divemesh::stereo
