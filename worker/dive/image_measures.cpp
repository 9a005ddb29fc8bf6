#include "worker/dive/image_measures.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr int kWidth_px = 640;
constexpr int kCell_px = 32;
constexpr std::size_t kMinCells = 20;  // fewer say nothing of the image
constexpr double kBlackLevel = 3.0;    // of 255, mean over a cell
constexpr int kMosaicBlock_px = 16;
constexpr std::size_t kMinBlocks = 100;  // fewer are not enough to average noise out
constexpr double kMinContrast = 0.4;     // grey values; corners with less are lost in 8 bits
constexpr double kNoiseGain = 0.126;     // of white noise through the band of has_texture()
constexpr double kTextureOverNoise = 2.0;

// Returns the middle of an image, at most kWidth_px wide and high: enough for what is the same all
// over it.
cv::Mat middle(const cv::Mat& image) {
    const int width = std::min(image.cols, kWidth_px);
    const int height = std::min(image.rows, kWidth_px);
    return image(cv::Rect((image.cols - width) / 2, (image.rows - height) / 2, width, height));
}

// Returns details of a size: the difference of two Gaussians, of sigma and twice that.
cv::Mat band(const cv::Mat& image, double sigma_px) {
    cv::Mat fine;
    cv::Mat coarse;
    cv::GaussianBlur(image, fine, {}, sigma_px);
    cv::GaussianBlur(image, coarse, {}, 2.0 * sigma_px);
    return fine - coarse;
}

double deviation(const cv::Mat& image) {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(image, mean, deviation);
    return deviation[0];
}

// Returns the mean of |2 I(p) - I(p - step) - I(p + step)| over the pixels p that are two or more
// from the borders along the step, which is of one or two pixels right or down.
double mean_step(const cv::Mat& image, cv::Point step) {
    constexpr int kRim_px = 2;
    const int left = step.x > 0 ? kRim_px : 0;
    const int top = step.y > 0 ? kRim_px : 0;
    const int width = image.cols - 2 * left;
    const int height = image.rows - 2 * top;
    const std::ptrdiff_t apart = static_cast<std::ptrdiff_t>(image.step[0]) * step.y + step.x;
    std::int64_t sum = 0;
    for (int v = top; v < top + height; ++v) {
        const auto* row = image.ptr<unsigned char>(v) + left;
        std::int32_t sum_of_row = 0;
        for (std::ptrdiff_t u = 0; u < width; ++u)
            sum_of_row += std::abs(2 * row[u] - row[u - apart] - row[u + apart]);
        sum += sum_of_row;
    }
    return static_cast<double>(sum) / (1.0 * width * height);
}

std::size_t num_cells(const cv::Mat& image) {
    return static_cast<std::size_t>(image.cols / kCell_px) *
           static_cast<std::size_t>(image.rows / kCell_px);
}

// Returns the square cells that the scene can be in: not those outside the circle of a fisheye
// lens, nor those that no lamp reaches.
std::vector<cv::Rect> lit_cells(const cv::Mat& image) {
    std::vector<cv::Rect> cells;
    for (int y = 0; y + kCell_px <= image.rows; y += kCell_px)
        for (int x = 0; x + kCell_px <= image.cols; x += kCell_px) {
            const cv::Rect cell(x, y, kCell_px, kCell_px);
            if (cv::mean(image(cell))[0] > kBlackLevel) cells.push_back(cell);
        }
    return cells;
}

// Returns the median over cells of a measure.
template <typename Get>
double median_of_cells(const cv::Mat& image, const std::vector<cv::Rect>& cells, const Get& get) {
    std::vector<double> values;
    values.reserve(cells.size());
    for (const cv::Rect& cell : cells) values.push_back(get(image(cell)));
    return stats::upper_median(std::move(values));
}

// Returns the standard deviation of white noise (Immerkaer 1996).
double noise_level(const cv::Mat& image, const std::vector<cv::Rect>& cells) {
    const cv::Matx33f kernel(1, -2, 1, -2, 4, -2, 1, -2, 1);
    cv::Mat second;
    cv::filter2D(image, second, CV_32F, kernel);
    return std::sqrt(0.5 * std::numbers::pi) / 6.0 *
           median_of_cells(
               cv::abs(second), cells, [](const cv::Mat& cell) { return cv::mean(cell)[0]; });
}

}  // namespace

cv::Mat reduced_to_640_px(const cv::Mat& image) {
    cv::Mat result;
    image.convertTo(result, CV_32F);
    if (image.cols <= kWidth_px) return result;
    const double scale = static_cast<double>(kWidth_px) / image.cols;
    cv::resize(result, result, {}, scale, scale, cv::INTER_AREA);
    return result;
}

double sharpness(const cv::Mat& image) {
    const cv::Mat fine = reduced_to_640_px(image);
    cv::Mat coarse;
    cv::resize(fine, coarse, {}, 0.25, 0.25, cv::INTER_AREA);
    const double reference = deviation(band(coarse, 1.2));
    return reference > 0.0 ? deviation(band(fine, 1.2)) / reference : 0.0;
}

double combing(const cv::Mat& image) {
    if (image.rows < 16 || image.cols < 16) return 1.0;
    const cv::Mat part = middle(image);
    const double across_lines = mean_step(part, {0, 1}) / std::max(1e-6, mean_step(part, {0, 2}));
    const double across_columns = mean_step(part, {1, 0}) / std::max(1e-6, mean_step(part, {2, 0}));
    return across_columns > 0.0 ? across_lines / across_columns : 1.0;
}

double mosaic_contrast(const cv::Mat& image) {
    const cv::Mat part = middle(image);
    const double mean = cv::mean(part)[0];
    if (mean < 1.0) return 0.0;
    std::vector<double> diagonal;
    std::vector<double> by_row;
    std::vector<double> by_column;
    for (int y = 0; y + kMosaicBlock_px <= part.rows; y += kMosaicBlock_px)
        for (int x = 0; x + kMosaicBlock_px <= part.cols; x += kMosaicBlock_px) {
            double sum[2][2] = {{0, 0}, {0, 0}};
            for (int v = 0; v < kMosaicBlock_px; ++v) {
                const unsigned char* row = part.ptr<unsigned char>(y + v) + x;
                for (int u = 0; u < kMosaicBlock_px; ++u) sum[v % 2][u % 2] += row[u];
            }
            diagonal.push_back(sum[0][0] + sum[1][1] - sum[0][1] - sum[1][0]);
            by_row.push_back(sum[0][0] + sum[0][1] - sum[1][0] - sum[1][1]);
            by_column.push_back(sum[0][0] + sum[1][0] - sum[0][1] - sum[1][1]);
        }
    if (diagonal.size() < kMinBlocks) return 0.0;
    // Two pixels of a cell against the other two, of 64 cells in a block.
    constexpr int kHalf_px = kMosaicBlock_px / 2;
    const double scale = 2.0 * kHalf_px * kHalf_px * mean;
    double contrast = 0.0;
    for (std::vector<double>* values : {&diagonal, &by_row, &by_column})
        contrast = std::max(contrast, std::abs(stats::median(std::move(*values))) / scale);
    return contrast;
}

bool is_dark(const cv::Mat& image) {
    const cv::Mat small = reduced_to_640_px(image);
    return num_cells(small) >= kMinCells && lit_cells(small).size() < kMinCells;
}

bool has_texture(const cv::Mat& image) {
    const cv::Mat small = reduced_to_640_px(image);
    if (num_cells(small) < kMinCells) return true;
    const std::vector<cv::Rect> cells = lit_cells(small);
    if (cells.size() < kMinCells) return false;
    const double contrast = median_of_cells(band(small, 1.5), cells, deviation);
    const double noise = kNoiseGain * noise_level(small, cells);
    return contrast > std::max(kMinContrast, kTextureOverNoise * noise);
}

}  // namespace divemesh::dive
