#include "worker/stereo/single_scale_matcher.hpp"

#include <functional>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "worker/stereo/block_matcher.hpp"
#include "worker/stereo/census_sgm.hpp"
#include "worker/stereo/disparity_doubt.hpp"
#include "worker/stereo/disparity_sigma.hpp"
#include "worker/stereo/matching_images.hpp"
#include "worker/stereo/refine_disparity.hpp"
#include "worker/stereo/sgm_kernels.hpp"
#include "worker/stereo/sigma_limits.hpp"
#include "worker/stereo/speckles.hpp"
#include "worker/stereo/weak_surface.hpp"

namespace divemesh::stereo {
namespace {

constexpr float kMaxStep_px = 1.5F;  // between neighbours of one surface
constexpr float kMaxSigma_px = 1.0F;

// Refines the disparity, removes islands that remain after the refinement or that it made by
// removing pixels without texture, and adds what lies between measured surface.
void refine(const types::RectifiedFrame& frame,
            DisparityRefiner& refiner,
            WeakSurface& weak,
            types::DepthMap& depth) {
    const IslandLimits islands = IslandLimits::of(frame.left.size());
    unconfirm_speckles(depth.disparity_px, islands.min_pixels, kMaxStep_px);
    const cv::Mat winners_px = depth.disparity_px.clone();
    depth.sigma_disparity_px =
        cv::max(refiner.refine(frame.left, frame.right, depth.disparity_px), kMinSigma_px);
    remove_speckles(depth.disparity_px, islands.min_pixels, kMaxStep_px);
    remove_unsupported(
        depth.disparity_px, depth.sigma_disparity_px, islands.min_support, kMaxStep_px);
    add_doubt(winners_px, depth.sigma_disparity_px);
    weak.add(winners_px, depth.disparity_px, depth.sigma_disparity_px);
}

void rate_by_texture(const types::RectifiedFrame& frame, types::DepthMap& depth) {
    depth.sigma_disparity_px = disparity_sigma(frame.left);
    depth.disparity_px.setTo(0.0, depth.sigma_disparity_px > kMaxSigma_px);
    depth.sigma_disparity_px = cv::min(depth.sigma_disparity_px, kMaxSigma_px);
    remove_speckles(
        depth.disparity_px, IslandLimits::of(frame.left.size()).min_pixels, kMaxStep_px);
}

// OpenCV's single-pass semi-global matcher, for comparison.
class OpenCvSgbm {
public:
    explicit OpenCvSgbm(int num_disparities)
        : matcher_(cv::StereoSGBM::create(
              0, num_disparities, 3, 72, 288, 1, 31, 5, 0, 0, cv::StereoSGBM::MODE_SGBM_3WAY)) {}

    cv::Mat compute(const cv::Mat& left, const cv::Mat& right) {
        cv::Mat fixed_point, disparity;
        matcher_->compute(left, right, fixed_point);
        fixed_point.convertTo(disparity, CV_32F, 1.0 / 16.0);
        disparity.setTo(0.0, disparity < 0.0);
        return disparity;
    }

private:
    cv::Ptr<cv::StereoSGBM> matcher_;
};

}  // namespace

struct SingleScaleMatcher::Implementation {
    std::function<void(const types::RectifiedFrame& frame,
                       const std::vector<SearchTile>& tiles,
                       types::DepthMap& depth)>
        compute;
    std::optional<DisparityRefiner> refiner;
    WeakSurface weak;

    void use_sgm(int num_disparities_px) {
        compute = [matcher = CensusSgm(num_disparities_px)](const types::RectifiedFrame& frame,
                                                            const std::vector<SearchTile>& tiles,
                                                            types::DepthMap& depth) mutable {
            const MatchingImages images = matching_images(frame);
            depth.disparity_px =
                matcher.compute(images.left, images.right, tiles, images.tolerance);
        };
        refiner.emplace();
    }
};

SingleScaleMatcher::SingleScaleMatcher(const std::string& method, int num_disparities_px)
    : implementation_(std::make_unique<Implementation>()) {
    const auto use = [&](auto matcher) {
        implementation_->compute = [matcher](const types::RectifiedFrame& frame,
                                             const std::vector<SearchTile>&,
                                             types::DepthMap& depth) mutable {
            depth.disparity_px = matcher.compute(frame.left, frame.right);
        };
    };
    if (method == "block")
        use(BlockMatcher(num_disparities_px));
    else if (method == "opencv_sgbm")
        use(OpenCvSgbm(num_disparities_px));
    else
        implementation_->use_sgm(num_disparities_px);
}

SingleScaleMatcher::~SingleScaleMatcher() = default;

bool SingleScaleMatcher::searches_within_range() const {
    return implementation_->refiner.has_value();
}

types::DepthMap SingleScaleMatcher::match(const types::RectifiedFrame& frame,
                                          const types::DisparityRange& range) {
    return match(frame, {{cv::Rect({}, frame.left.size()), range}});
}

types::DepthMap SingleScaleMatcher::match(const types::RectifiedFrame& frame,
                                          const std::vector<SearchTile>& tiles) {
    types::DepthMap depth;
    auto& own = *implementation_;
    own.compute(frame, tiles, depth);
    if (own.refiner)
        refine(frame, *own.refiner, own.weak, depth);
    else
        rate_by_texture(frame, depth);
    depth.sigma_disparity_px.setTo(0.0, depth.disparity_px <= 0.0);
    return depth;
}

}  // namespace divemesh::stereo
