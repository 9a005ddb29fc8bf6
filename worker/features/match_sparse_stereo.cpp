#include "worker/features/match_sparse_stereo.hpp"

#include <algorithm>
#include <cmath>

#include "worker/features/align_patch.hpp"
#include "worker/features/epipolar_search.hpp"
#include "worker/types/disparity_range.hpp"

namespace divemesh::features {
namespace {

constexpr double kMinCorrelation = 0.8;
constexpr double kMinDisparity_px = 1.0;
constexpr double kMaxRowOffset_px = 1.0;
constexpr double kNearer = 1.33;  // times a known disparity

// Returns the refined disparity. The patch moves in both directions: otherwise a slightly wrong
// rectification would turn slanted edges into disparity.
double refine(const Patch& patch,
              const cv::Mat& right,
              const types::Feature& feature,
              double guess_px) {
    const auto found = patch.align(right, {feature.pixel.x() - guess_px, feature.pixel.y()});
    if (!found || found->correlation < kMinCorrelation ||
        std::abs(found->pixel.y() - feature.pixel.y()) > kMaxRowOffset_px)
        return 0.0;
    const double disparity = feature.pixel.x() - found->pixel.x();
    return disparity >= kMinDisparity_px ? disparity : 0.0;
}

double dense_at(const cv::Mat& dense_px, const Eigen::Vector2d& pixel) {
    const int u = static_cast<int>(std::lround(pixel.x()));
    const int v = static_cast<int>(std::lround(pixel.y()));
    if (u < 0 || v < 0 || u >= dense_px.cols || v >= dense_px.rows) return 0.0;
    return dense_px.at<float>(v, u);
}

// Returns how many disparities are searched for a feature: where its depth is known, a large image
// need not be searched for all that may be near.
int num_searched(const types::RectifiedFrame& frame,
                 int num_disparities_px,
                 const types::Feature& feature) {
    const int limit_px = types::max_disparities_px(num_disparities_px, frame.left.cols);
    if (!types::has_depth(feature)) return limit_px;
    const double nearer_px = kNearer * std::min<double>(feature.disparity_px, limit_px);
    return std::clamp(static_cast<int>(std::ceil(nearer_px)), num_disparities_px, limit_px);
}

double measure(const types::RectifiedFrame& frame,
               const cv::Mat& dense_px,
               int num_disparities_px,
               EpipolarSearch& row,
               const types::Feature& feature) {
    if (!frame.shows_scene(feature.pixel)) return 0.0;
    const auto patch = Patch::read(frame.left, feature.pixel);
    if (!patch) return 0.0;
    if (!dense_px.empty()) {  // the dense matcher decides
        const double guess = dense_at(dense_px, feature.pixel);
        return guess > 0.0 ? refine(*patch, frame.right, feature, guess) : 0.0;
    }
    if (types::has_depth(feature)) {
        const double disparity = refine(
            *patch, frame.right, feature, frame.matched_px(feature.pixel, feature.disparity_px));
        if (disparity > 0.0) return disparity;
    }
    const int found = row.find(frame.left,
                               frame.right,
                               static_cast<int>(std::lround(feature.pixel.x())),
                               static_cast<int>(std::lround(feature.pixel.y())),
                               num_searched(frame, num_disparities_px, feature));
    return found > 0 ? refine(*patch, frame.right, feature, found) : 0.0;
}

}  // namespace

void match_sparse_stereo(const types::RectifiedFrame& frame,
                         const cv::Mat& dense_px,
                         int num_disparities_px,
                         types::Features& features) {
    EpipolarSearch row;
    for (types::Feature& feature : features) {
        feature.disparity_px = measure(frame, dense_px, num_disparities_px, row, feature);
        if (types::has_depth(feature))
            feature.disparity_px = frame.disparity_px(feature.pixel, feature.disparity_px);
    }
}

}  // namespace divemesh::features
