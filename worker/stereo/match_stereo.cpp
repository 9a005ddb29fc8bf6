#include "worker/stereo/match_stereo.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "worker/stereo/coarse_disparity_search.hpp"
#include "worker/stereo/combine_scales.hpp"
#include "worker/stereo/search_tiles.hpp"
#include "worker/stereo/sgm_kernels.hpp"
#include "worker/stereo/single_scale_matcher.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kStep_px = 64;     // of the number of disparities; the narrowest search of a tile
constexpr int kMinHalf_px = 40;  // width and height; smaller halves show nothing

// Returns how many disparities, px of the whole size, are searched at most at half the size. Half
// as many again cost little there.
int max_half_disparities_px(int limit_px) {
    const int wide = limit_px + limit_px / 2 / kStep_px * kStep_px;
    return std::min(2 * kMaxDisparities, wide);
}

types::RectifiedFrame halved(const types::RectifiedFrame& frame) {
    const cv::Size size(frame.left.cols / 2, frame.left.rows / 2);
    const cv::Rect whole(0, 0, 2 * size.width, 2 * size.height);
    types::RectifiedFrame half{frame.index, frame.timestamp_ns, {}, {}};
    cv::resize(frame.left(whole), half.left, size, 0.0, 0.0, cv::INTER_AREA);
    cv::resize(frame.right(whole), half.right, size, 0.0, 0.0, cv::INTER_AREA);
    return half;
}

}  // namespace

struct StereoMatcher::Implementation {
    Implementation(const std::string& method, int num_disparities, int num_scales)
        : num_disparities_px(num_disparities),
          combines_scales(num_scales > 1),
          full_size(method, num_disparities) {
        if (full_size.searches_within_range()) half_size.emplace(method, num_disparities);
    }

    // Makes the survey at the first frame, which tells the size of the images.
    CoarseDisparitySearch& survey_of(int limit_px) {
        if (!survey || surveyed_px != limit_px) survey.emplace(limit_px);
        surveyed_px = limit_px;
        return *survey;
    }

    int num_disparities_px;
    bool combines_scales;
    SingleScaleMatcher full_size;
    std::optional<SingleScaleMatcher> half_size;
    std::optional<CoarseDisparitySearch> survey;
    int surveyed_px = 0;
};

StereoMatcher::StereoMatcher(const std::string& method, int num_disparities_px, int num_scales)
    : implementation_(std::make_unique<Implementation>(method, num_disparities_px, num_scales)) {}

StereoMatcher::~StereoMatcher() = default;

types::DepthMap StereoMatcher::match(const types::RectifiedFrame& frame) {
    return match(frame, {0, implementation_->num_disparities_px});
}

types::DepthMap StereoMatcher::match(const types::RectifiedFrame& frame,
                                     const types::DisparityRange& range) {
    auto& own = *implementation_;
    const bool within_range = own.full_size.searches_within_range();
    const int limit_px = within_range
                             ? types::max_disparities_px(own.num_disparities_px, frame.left.cols)
                             : own.num_disparities_px;
    const auto surveyed = own.survey_of(limit_px).survey(frame.left, frame.right);
    const types::DisparityRange at_full_size =
        within_range ? widen(range, surveyed, limit_px) : types::DisparityRange{0, limit_px};
    const bool has_half =
        own.half_size && std::min(frame.left.cols, frame.left.rows) / 2 >= kMinHalf_px;
    const bool combines = has_half && own.combines_scales;
    const bool by_tiles =
        has_half && frame.left.cols > types::kLargeWidth_px && at_full_size.num_px > kStep_px;
    const types::DisparityRange searched =
        combines ? widen(at_full_size, surveyed, max_half_disparities_px(limit_px)) : at_full_size;
    types::DepthMap half;
    if (combines || by_tiles)
        half =
            own.half_size->match(halved(frame), {searched.first_px / 2, (searched.num_px + 1) / 2});
    types::DepthMap depth =
        by_tiles ? own.full_size.match(
                       frame, search_tiles(half.disparity_px, frame.left.size(), at_full_size))
                 : own.full_size.match(frame, at_full_size);
    if (combines) combine_scales(half, depth);
    depth.search = outcome_of(searched, surveyed);
    return depth;
}

}  // namespace divemesh::stereo
