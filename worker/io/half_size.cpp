#include "worker/io/half_size.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace divemesh::io {
namespace {

cv::Vec4b mean_of(std::span<const cv::Vec4b> pixels) {
    cv::Vec4i sum;
    for (const cv::Vec4b& pixel : pixels)
        if (pixel[3] != 0) sum += cv::Vec4i(pixel[0], pixel[1], pixel[2], 1);
    const int count = sum[3];
    if (count == 0) return {};
    const auto mean = [&](int channel) {
        return static_cast<std::uint8_t>((sum[channel] + count / 2) / count);
    };
    return {mean(0), mean(1), mean(2), 255};
}

float mean_of(std::span<const float> pixels) {
    float sum = 0.0F;
    float count = 0.0F;
    for (const float value : pixels) {
        if (std::isnan(value)) continue;
        sum += value;
        count += 1.0F;
    }
    return count == 0.0F ? std::numeric_limits<float>::quiet_NaN() : sum / count;
}

template <typename Pixel>
void halve(const cv::Mat& raster, cv::Mat& half) {
    for (int row = 0; row < half.rows; ++row) {
        const std::array<const Pixel*, 2> above = {
            raster.ptr<Pixel>(2 * row), raster.ptr<Pixel>(std::min(2 * row + 1, raster.rows - 1))};
        const std::size_t num_rows = 2 * row + 1 < raster.rows ? 2 : 1;
        for (int column = 0; column < half.cols; ++column) {
            std::array<Pixel, 4> square;
            std::size_t count = 0;
            for (std::size_t i = 0; i < num_rows; ++i)
                for (int of = 2 * column; of < std::min(2 * column + 2, raster.cols); ++of)
                    square[count++] = above[i][of];
            half.at<Pixel>(row, column) = mean_of(std::span<const Pixel>(square.data(), count));
        }
    }
}

}  // namespace

cv::Mat half_size(const cv::Mat& raster) {
    cv::Mat half((raster.rows + 1) / 2, (raster.cols + 1) / 2, raster.type());
    if (raster.type() == CV_8UC4)
        halve<cv::Vec4b>(raster, half);
    else
        halve<float>(raster, half);
    return half;
}

}  // namespace divemesh::io
