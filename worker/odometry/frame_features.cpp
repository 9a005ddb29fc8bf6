#include "worker/odometry/frame_features.hpp"

#include <algorithm>
#include <iterator>
#include <unordered_set>
#include <utility>

#include "worker/features/match_sparse_stereo.hpp"
#include "worker/features/surface_slope.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::odometry {
namespace {

// Returns the inliers of a motion at one of its two times.
types::Features static_features(const Registration& motion, Eigen::Vector3d PointPair::*time_px) {
    types::Features features;
    if (!motion.found) return features;
    for (const PointPair& pair : motion.inliers)
        features.push_back({pair.id, (pair.*time_px).head<2>(), (pair.*time_px).z()});
    return features;
}

}  // namespace

std::uint64_t seed_of(std::int64_t seed, const types::RectifiedFrame& frame) {
    return static_cast<std::uint64_t>(seed) * 1'000'003U + static_cast<std::uint64_t>(frame.index);
}

Eigen::Isometry3d first_pose(const imu::InertialPrior& inertial,
                             const types::RectifiedRig& rig,
                             std::int64_t timestamp_ns) {
    Eigen::Isometry3d T_world_imu = Eigen::Isometry3d::Identity();
    T_world_imu.linear() =
        inertial.initial_orientation(timestamp_ns, rig.T_imu_cam.linear()).toRotationMatrix();
    return T_world_imu * rig.T_imu_cam;
}

types::Features without_dynamic_features(const types::Features& tracks,
                                         const PointPairs& pairs,
                                         const Registration& motion) {
    std::unordered_set<std::int64_t> outliers;
    if (motion.found)
        for (const PointPair& pair : pairs) outliers.insert(pair.id);
    for (const PointPair& pair : motion.inliers) outliers.erase(pair.id);
    types::Features features;
    for (const types::Feature& feature : tracks)
        if (!outliers.contains(feature.id)) features.push_back(feature);
    return features;
}

std::size_t num_with_depth(const types::Features& features) {
    return static_cast<std::size_t>(
        std::count_if(features.begin(), features.end(), types::has_depth));
}

double median_disparity_px(const types::Features& features) {
    std::vector<double> disparities_px;
    disparities_px.reserve(features.size());
    for (const types::Feature& feature : features)
        if (types::has_depth(feature)) disparities_px.push_back(feature.disparity_px);
    return disparities_px.empty() ? 0.0 : stats::median(std::move(disparities_px));
}

types::FrameFeatures feature_counts(const types::Features& features) {
    return {static_cast<std::int32_t>(features.size()),
            static_cast<std::int32_t>(num_with_depth(features))};
}

types::Features static_features(const Registration& motion) {
    return static_features(motion, &PointPair::current_px);
}

types::Features previous_static_features(const Registration& motion) {
    return static_features(motion, &PointPair::previous_px);
}

void add_lost_features(const types::RectifiedFrame& frame,
                       const Eigen::Isometry3d& T_current_previous,
                       int num_disparities_px,
                       const KnownScene& scene,
                       features::FeatureTracker& tracker,
                       types::Features& features) {
    types::Features found = tracker.find_lost(T_current_previous, features);
    std::erase_if(found, [&](const types::Feature& f) { return !scene.has_followed(f.id); });
    features::match_sparse_stereo(frame, {}, num_disparities_px, found);
    types::Features all;
    std::set_union(features.begin(),
                   features.end(),
                   found.begin(),
                   found.end(),
                   std::back_inserter(all),
                   [](const types::Feature& a, const types::Feature& b) { return a.id < b.id; });
    features = std::move(all);
}

void add_new_features(const types::RectifiedRig& rig,
                      const types::RectifiedFrame& frame,
                      const types::DepthMap& depth,
                      int num_disparities_px,
                      features::FeatureTracker& tracker,
                      types::Features& features) {
    types::Features fresh = tracker.detect(features, frame.fixed_pattern);
    features::match_sparse_stereo(frame, depth.disparity_px, num_disparities_px, fresh);
    features::measure_slopes(rig, frame, fresh);
    features.insert(features.end(), fresh.begin(), fresh.end());
}

void learn_bias(imu::InertialPrior& inertial,
                const types::RectifiedRig& rig,
                const Registration& vision,
                std::int64_t before_ns,
                std::int64_t now_ns) {
    if (!inertial.has_gyroscope() || !vision.found) return;
    const RefinedPose refined =
        refine_pose(rig, vision.inliers, {vision.T_current_previous, std::nullopt, 0.0});
    if (refined.outcome.failed()) return;
    const Eigen::Quaterniond q_imu_cam(rig.T_imu_cam.linear());
    const Eigen::Quaterniond q_previous_current(refined.T_current_previous.linear().transpose());
    inertial.learn_bias(before_ns, now_ns, q_imu_cam * q_previous_current * q_imu_cam.conjugate());
}

}  // namespace divemesh::odometry
