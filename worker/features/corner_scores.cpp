#include "worker/features/corner_scores.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace divemesh::features {
namespace {

constexpr int kBlock_px = 5;
constexpr float kSobelSum = 8.0F;
constexpr float kScale = 1.0F / (kSobelSum * kSobelSum * kBlock_px * kBlock_px);

// g g^T of one image row, with one array for each of its three numbers.
struct Products {
    std::int32_t* x_x;
    std::int32_t* x_y;
    std::int32_t* y_y;

    Products(std::int32_t* first, std::size_t width)
        : x_x(first), x_y(first + width), y_y(first + 2 * width) {}
};

// Replaces the products of five rows before by those of `row`, in the sums too.
DIVEMESH_INLINE_BODY void add_row(
    const std::uint8_t* row, std::ptrdiff_t step, int width, Products kept, Products sums) {
    const std::uint8_t* __restrict above = row - step;
    const std::uint8_t* __restrict here = row;
    const std::uint8_t* __restrict below = row + step;
    std::int32_t* __restrict kept_xx = kept.x_x;
    std::int32_t* __restrict kept_xy = kept.x_y;
    std::int32_t* __restrict kept_yy = kept.y_y;
    std::int32_t* __restrict sum_xx = sums.x_x;
    std::int32_t* __restrict sum_xy = sums.x_y;
    std::int32_t* __restrict sum_yy = sums.y_y;
    for (int u = 1; u < width - 1; ++u) {
        const auto x = static_cast<std::int16_t>(above[u + 1] - above[u - 1] +
                                                 2 * (here[u + 1] - here[u - 1]) + below[u + 1] -
                                                 below[u - 1]);
        const auto y = static_cast<std::int16_t>(
            below[u - 1] - above[u - 1] + 2 * (below[u] - above[u]) + below[u + 1] - above[u + 1]);
        const std::int32_t x_x = std::int32_t{x} * x;
        const std::int32_t x_y = std::int32_t{x} * y;
        const std::int32_t y_y = std::int32_t{y} * y;
        sum_xx[u] += x_x - kept_xx[u];
        sum_xy[u] += x_y - kept_xy[u];
        sum_yy[u] += y_y - kept_yy[u];
        kept_xx[u] = x_x;
        kept_xy[u] = x_y;
        kept_yy[u] = y_y;
    }
}

DIVEMESH_INLINE_BODY float sum_of_five(const std::int32_t* middle) {
    return static_cast<float>(middle[-2] + middle[-1] + middle[0] + middle[1] + middle[2]);
}

DIVEMESH_INLINE_BODY void score_row(Products sums, int width, float* __restrict scores) {
    const std::int32_t* __restrict x_x = sums.x_x;
    const std::int32_t* __restrict x_y = sums.x_y;
    const std::int32_t* __restrict y_y = sums.y_y;
    for (int u = CornerScores::kBorder_px; u < width - CornerScores::kBorder_px; ++u) {
        const float a = 0.5F * kScale * sum_of_five(x_x + u);
        const float b = kScale * sum_of_five(x_y + u);
        const float c = 0.5F * kScale * sum_of_five(y_y + u);
        scores[u] = a + c - std::sqrt((a - c) * (a - c) + b * b);
    }
}

}  // namespace

const cv::Mat& CornerScores::of(const cv::Mat& image) {
    const auto add = base::compiled_for<add_row>(instructions_);
    const auto score = base::compiled_for<score_row>(instructions_);
    const auto width = static_cast<std::size_t>(image.cols);
    products_.assign(3 * width * (kBlock_px + 1), 0);
    const Products sums(products_.data() + 3 * width * kBlock_px, width);
    scores_.create(image.size(), CV_32F);
    scores_ = 0.0F;
    for (int v = 1; v < image.rows - 1; ++v) {
        const Products kept(products_.data() + static_cast<std::size_t>(v % kBlock_px) * 3 * width,
                            width);
        add(image.ptr<std::uint8_t>(v),
            static_cast<std::ptrdiff_t>(image.step[0]),
            image.cols,
            kept,
            sums);
        const int middle = v - kBlock_px / 2;
        if (middle < kBorder_px) continue;
        score(sums, image.cols, scores_.ptr<float>(middle));
    }
    return scores_;
}

std::vector<cv::Point> best_of_cells(const cv::Mat& scores,
                                     float min_score,
                                     int border_px,
                                     int cell_px) {
    std::vector<cv::Point> corners;
    for (int top = border_px; top < scores.rows - border_px; top += cell_px) {
        for (int start = border_px; start < scores.cols - border_px; start += cell_px) {
            const cv::Rect cell(start,
                                top,
                                std::min(cell_px, scores.cols - border_px - start),
                                std::min(cell_px, scores.rows - border_px - top));
            double score = 0.0;
            cv::Point at;
            cv::minMaxLoc(scores(cell), nullptr, &score, nullptr, &at);
            if (score >= min_score) corners.push_back(at + cell.tl());
        }
    }
    return corners;
}

}  // namespace divemesh::features
