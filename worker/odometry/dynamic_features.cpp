#include "worker/odometry/dynamic_features.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <unordered_set>
#include <utility>

namespace divemesh::odometry {
namespace {

constexpr double kStill_px = 1.0;          // half the outlier tolerance
constexpr double kMaxStep_px = 1.0;        // of disparity within one component
constexpr double kSameComponent_px = 2.0;  // between its disparity and the feature's
constexpr double kMaxShare = 0.25;         // of the image that a fish fills
constexpr int kRim_px = 3;                 // where disparities of both sides mix

bool by_id(const types::Feature& a, const types::Feature& b) { return a.id < b.id; }

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

types::Features DynamicFeatures::with_dynamic(const types::Features& scene) const {
    types::Features all;
    std::merge(scene.begin(),
               scene.end(),
               features_.begin(),
               features_.end(),
               std::back_inserter(all),
               by_id);
    return all;
}

void DynamicFeatures::take_dynamic(types::Features& tracks) {
    previous_ = std::exchange(features_, {});
    std::set_intersection(tracks.begin(),
                          tracks.end(),
                          previous_.begin(),
                          previous_.end(),
                          std::back_inserter(features_),
                          by_id);
    std::erase_if(tracks, [&](const types::Feature& feature) {
        return std::binary_search(features_.begin(), features_.end(), feature, by_id);
    });
}

void DynamicFeatures::classify(const PointPairs& pairs, const Registration& motion) {
    started_.clear();
    if (!motion.found) return;
    std::erase_if(features_, [&](const types::Feature& feature) {
        return moves_with_scene(motion.T_current_previous, feature);
    });
    std::unordered_set<std::int64_t> inliers;
    for (const PointPair& pair : motion.inliers) inliers.insert(pair.id);
    types::Features fresh;
    for (const PointPair& pair : pairs) {
        if (inliers.contains(pair.id)) continue;
        fresh.push_back({pair.id, pair.current_px.head<2>(), pair.current_px.z()});
        started_.push_back({pair.id, pair.previous_px.head<2>(), pair.previous_px.z()});
    }
    features_ = with_dynamic(fresh);
}

bool DynamicFeatures::moves_with_scene(const Eigen::Isometry3d& T_current_previous,
                                       const types::Feature& feature) const {
    const auto before = std::lower_bound(previous_.begin(), previous_.end(), feature, by_id);
    if (before == previous_.end() || before->id != feature.id || !types::has_depth(*before) ||
        !types::has_depth(feature))
        return false;
    const Eigen::Vector3d p_cam = T_current_previous * types::point_cam(rig_, *before);
    return p_cam.z() > 0.0 &&
           (types::project_px(rig_, p_cam) - types::measurement_px(feature)).norm() < kStill_px;
}

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

}  // namespace divemesh::odometry
