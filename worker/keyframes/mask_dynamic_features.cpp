#include "worker/keyframes/mask_dynamic_features.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <unordered_set>

namespace divemesh::keyframes {
namespace {

constexpr double kMaxStep_px = 1.0;        // of disparity within one component
constexpr double kSameComponent_px = 2.0;  // between its disparity and the feature's
constexpr double kMaxShare = 0.25;         // of the image that a fish fills
constexpr int kRim_px = 3;                 // where disparities of both sides mix

cv::Point pixel_of(const types::Feature& feature) {
    return {static_cast<int>(std::lround(feature.pixel.x())),
            static_cast<int>(std::lround(feature.pixel.y()))};
}

// The connected components of a disparity image; each is returned once, however many features lie
// on it.
class DepthComponents {
public:
    explicit DepthComponents(const cv::Mat& disparity_px)
        : disparity_px_(disparity_px),
          found_(disparity_px.rows + 2, disparity_px.cols + 2, CV_8U, cv::Scalar(0)) {}

    struct DepthComponent {
        cv::Rect where;
        cv::Mat mask;  // of the size of `where`
    };
    // Returns the component under a feature; nullopt if no pixel there has its depth, or the
    // component has been returned before.
    std::optional<DepthComponent> take_component_at(const types::Feature& feature);

private:
    cv::Mat disparity_px_;
    cv::Mat found_;  // with a one-pixel border
};

std::optional<DepthComponents::DepthComponent> DepthComponents::take_component_at(
    const types::Feature& feature) {
    constexpr int kThis = 2;
    constexpr int kBefore = 255;
    const cv::Point seed = pixel_of(feature);
    if (!cv::Rect({}, disparity_px_.size()).contains(seed) ||
        std::abs(disparity_px_.at<float>(seed) - feature.disparity_px) > kSameComponent_px ||
        found_.at<std::uint8_t>(seed + cv::Point(1, 1)) != 0)
        return {};
    DepthComponent component;
    const int num_pixels = cv::floodFill(disparity_px_,  // not changed, by FLOODFILL_MASK_ONLY
                                         found_,
                                         seed,
                                         {},
                                         &component.where,
                                         cv::Scalar(kMaxStep_px),
                                         cv::Scalar(kMaxStep_px),
                                         4 | cv::FLOODFILL_MASK_ONLY | (kThis << 8));
    cv::Mat found = found_(component.where + cv::Point(1, 1));
    component.mask = found == kThis;
    found.setTo(kBefore, component.mask);
    if (num_pixels > kMaxShare * static_cast<double>(disparity_px_.total())) return {};
    return component;
}

bool holds_any(const DepthComponents::DepthComponent& component, const types::Features& features) {
    return std::any_of(features.begin(), features.end(), [&](const types::Feature& feature) {
        const cv::Point pixel = pixel_of(feature);
        return component.where.contains(pixel) &&
               component.mask.at<std::uint8_t>(pixel - component.where.tl()) != 0;
    });
}

}  // namespace

void mask_dynamic_features(const types::Features& dynamic,
                           const types::Features& scene,
                           types::DepthMap& depth) {
    std::unordered_set<std::int64_t> moving_ids;
    for (const types::Feature& feature : dynamic) moving_ids.insert(feature.id);
    types::Features still = scene;
    std::erase_if(still,
                  [&](const types::Feature& feature) { return moving_ids.contains(feature.id); });
    cv::Mat out = cv::Mat::zeros(depth.disparity_px.size(), CV_8U);
    DepthComponents components(depth.disparity_px);
    for (const types::Feature& feature : dynamic) {
        if (!types::has_depth(feature)) continue;
        const auto component = components.take_component_at(feature);
        if (component && !holds_any(*component, still))
            out(component->where).setTo(255, component->mask);
    }
    cv::dilate(out, out, cv::Mat::ones(2 * kRim_px + 1, 2 * kRim_px + 1, CV_8U));
    depth.disparity_px.setTo(0.0F, out);
}

}  // namespace divemesh::keyframes
