#include "worker/odometry/dynamic_features.hpp"

#include <algorithm>
#include <iterator>
#include <unordered_set>
#include <utility>

namespace divemesh::odometry {
namespace {

constexpr double kStill_px = 1.0;  // half the outlier tolerance

bool by_id(const types::Feature& a, const types::Feature& b) { return a.id < b.id; }

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

}  // namespace divemesh::odometry
