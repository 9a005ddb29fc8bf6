#include "worker/compare/change_scatter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "worker/stats/distributions.hpp"
#include "worker/stats/quantile.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::compare {
namespace {

constexpr std::array kRanges_m = {0.0, 0.01, 0.02, 0.04, 0.08, 0.16};
constexpr std::size_t kMinCells = 200;

// Returns max - min within the element; 0 where no cell was seen.
cv::Mat range_of(const cv::Mat& height_m, const cv::Mat& element) {
    const cv::Mat unseen = ~cells_with_value(height_m);
    cv::Mat high = height_m.clone();
    cv::Mat low = height_m.clone();
    high.setTo(cv::Scalar::all(std::numeric_limits<float>::lowest()), unseen);
    low.setTo(cv::Scalar::all(std::numeric_limits<float>::max()), unseen);
    cv::dilate(high, high, element);
    cv::erode(low, low, element);
    cv::Mat range = high - low;
    range.setTo(cv::Scalar::all(0.0), unseen);
    return range;
}

// Returns the index (CV_8U) of each compared cell's class; those at an edge come last.
cv::Mat classes_of(const ChangeMap& map,
                   const SurfaceRaster& a,
                   const SurfaceRaster& b,
                   double scale_m) {
    const double scale_cells = scale_m / map.grid.cell_m;
    const cv::Mat element = disc(0.5 * scale_cells);
    const cv::Mat range = cv::max(range_of(a.height_m, element), range_of(b.height_m, element));
    cv::Mat edge;
    cv::dilate(~cells_with_value(map.change_m), edge, disc(scale_cells));
    cv::Mat classes = cv::Mat::zeros(range.size(), CV_8U);
    for (std::size_t i = 1; i < kRanges_m.size(); ++i)
        classes.setTo(cv::Scalar::all(static_cast<double>(i)), range >= kRanges_m[i]);
    cv::add(classes, cv::Scalar::all(static_cast<double>(kRanges_m.size())), classes, edge);
    return classes;
}

}  // namespace

double robust_sigma(std::vector<float>& sizes) {
    if (sizes.empty()) return 0.0;
    return std::max(
        static_cast<double>(stats::lower_quantile(sizes, 0.5)) * stats::kSigmasPerMad,
        static_cast<double>(stats::lower_quantile(sizes, 0.8)) / stats::normal_quantile(0.9));
}

std::vector<ScatterClass> scale_by_scatter(ChangeMap& map,
                                           const SurfaceRaster& a,
                                           const SurfaceRaster& b,
                                           double scale_m) {
    const cv::Mat classes = classes_of(map, a, b, scale_m);
    std::vector<std::vector<float>> ratios(2 * kRanges_m.size());
    for (int row = 0; row < classes.rows; ++row)
        for (int column = 0; column < classes.cols; ++column) {
            const float change = map.change_m.at<float>(row, column);
            if (change == change)
                ratios[classes.at<std::uint8_t>(row, column)].push_back(
                    std::abs(change) / map.sigma_m.at<float>(row, column));
        }
    std::vector<ScatterClass> scatter;
    for (std::size_t i = 0; i < ratios.size(); ++i) {
        const std::size_t num = ratios[i].size();
        ScatterClass one{kRanges_m[i % kRanges_m.size()], i >= kRanges_m.size(), num};
        one.factor = num >= kMinCells ? robust_sigma(ratios[i])
                     : i > 0          ? scatter.back().factor
                                      : 1.0;
        scatter.push_back(one);
    }
    for (int row = 0; row < classes.rows; ++row)
        for (int column = 0; column < classes.cols; ++column)
            map.sigma_m.at<float>(row, column) *=
                static_cast<float>(scatter[classes.at<std::uint8_t>(row, column)].factor);
    return scatter;
}

}  // namespace divemesh::compare
