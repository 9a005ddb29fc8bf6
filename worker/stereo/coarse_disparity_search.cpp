#include "worker/stereo/coarse_disparity_search.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "worker/stereo/speckles.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kScale = 4;
constexpr int kSpan = 2;  // times the full range
constexpr int kMinSpeckleSize = 24;
constexpr float kMaxStep_px = 1.5F;
// Share of the patches; fewer beyond the range do not widen it.
constexpr double kMinShare = 0.03;
constexpr int kStep_px = 64;
constexpr int kError_px = 6;  // of a surveyed disparity

int beyond(float disparity_px, const types::DisparityRange& range) {
    // Winners at the ends of a range are rejected.
    if (disparity_px < static_cast<float>(range.first_px + 1) && range.first_px > 0) return -1;
    return disparity_px > static_cast<float>(range.first_px + range.num_px - 2) ? 1 : 0;
}

}  // namespace

CoarseDisparitySearch::CoarseDisparitySearch(int num_disparities_px)
    : matcher_(std::min(512, kSpan * num_disparities_px / kScale)) {}

std::vector<float> CoarseDisparitySearch::survey(const cv::Mat& left, const cv::Mat& right) {
    const cv::Size size(left.cols / kScale, left.rows / kScale);
    if (size.empty()) return {};
    cv::resize(left, small_left_, size, 0, 0, cv::INTER_AREA);
    cv::resize(right, small_right_, size, 0, 0, cv::INTER_AREA);
    cv::Mat disparity = matcher_.compute(small_left_, small_right_);
    remove_speckles(disparity, kMinSpeckleSize, kMaxStep_px);
    const float scale = static_cast<float>(left.cols) / static_cast<float>(size.width);
    std::vector<float> disparities_px;
    for (int y = 0; y < disparity.rows; ++y)
        for (int x = 0; x < disparity.cols; ++x)
            if (disparity.at<float>(y, x) > 0.0F)
                disparities_px.push_back(scale * disparity.at<float>(y, x));
    std::sort(disparities_px.begin(), disparities_px.end());
    return disparities_px;
}

types::DisparityRange widen(const types::DisparityRange& range,
                            const std::vector<float>& surveyed,
                            int num_disparities_px) {
    const auto few = static_cast<std::size_t>(kMinShare * static_cast<double>(surveyed.size()));
    if (surveyed.empty()) return range;
    int first = range.first_px;
    int end = range.first_px + range.num_px;
    const float low_disparity = surveyed[few];
    const float high_disparity = surveyed[surveyed.size() - 1 - few];
    if (beyond(low_disparity, range) < 0)
        first = std::max(0, static_cast<int>(low_disparity) - kError_px);
    if (beyond(high_disparity, range) > 0)
        end = std::min(num_disparities_px, static_cast<int>(high_disparity) + kError_px);
    end = std::max(end, range.first_px + range.num_px);
    const int num = (end - first + kStep_px - 1) / kStep_px * kStep_px;
    if (num >= num_disparities_px) return {0, num_disparities_px};
    return {std::clamp(first, 0, num_disparities_px - num), num};
}

types::SearchOutcome outcome_of(const types::DisparityRange& range,
                                const std::vector<float>& surveyed) {
    types::SearchOutcome outcome{range, static_cast<std::int64_t>(surveyed.size()), 0, 0};
    for (const float disparity_px : surveyed) {
        const int side = beyond(disparity_px, range);
        outcome.num_too_far += side < 0 ? 1 : 0;
        outcome.num_too_near += side > 0 ? 1 : 0;
    }
    return outcome;
}

}  // namespace divemesh::stereo
