#include "worker/loops/relocaliser.hpp"

#include <algorithm>
#include <utility>

#include "worker/features/match_sparse_stereo.hpp"
#include "worker/loops/match_keypoints.hpp"

namespace divemesh::loops {
namespace {

// Measures the disparities of keypoints by searching along the rows of the right image.
void measure_disparities(const types::RectifiedFrame& frame,
                         int num_disparities_px,
                         features::DescribedKeypoints& keypoints) {
    types::Features corners;
    for (const features::DescribedKeypoint& point : keypoints)
        corners.push_back({0, {point.u_px, point.v_px}, 0.0});
    features::match_sparse_stereo(frame, {}, num_disparities_px, corners);
    for (std::size_t i = 0; i < keypoints.size(); ++i)
        keypoints[i].disparity_px = static_cast<float>(corners[i].disparity_px);
}

void join(const types::Features& known, types::Features& features) {
    const auto by_id = [](const types::Feature& a, const types::Feature& b) { return a.id < b.id; };
    types::Features all;
    std::set_union(features.begin(),
                   features.end(),
                   known.begin(),
                   known.end(),
                   std::back_inserter(all),
                   by_id);
    features = std::move(all);
}

}  // namespace

Relocaliser::Relocaliser(const types::RectifiedRig& rig, bool used, int num_disparities_px)
    : rig_(rig), used_(used), num_disparities_px_(num_disparities_px) {}

void Relocaliser::relocalise(const types::RectifiedFrame& frame,
                             std::uint64_t seed,
                             types::Features& features,
                             odometry::MotionModel& motion) {
    if (!used_) return;
    keypoints_ = features::describe_keypoints(frame.left);
    measure_disparities(frame, num_disparities_px_, keypoints_);
    if (!std::exchange(lost_, false) || last_left_.empty()) return;
    const auto known = match_last_keyframe(frame, seed);
    if (!known) return;
    motion.correct(T_world_last_ * known->T_current_reference.inverse());
    join(known->features, features);
}

std::optional<features::DescribedKeypoints> Relocaliser::keep(
    const types::RectifiedFrame& frame,
    const types::Features& features,
    const Eigen::Isometry3d& T_world_cam) {
    if (!used_) return std::nullopt;
    last_keypoints_ = std::move(keypoints_);
    last_left_ = frame.left;
    last_features_.clear();
    for (const types::Feature& feature : features)
        if (types::has_depth(feature)) last_features_.push_back(feature);
    T_world_last_ = T_world_cam;
    return last_keypoints_;
}

std::optional<Relocaliser::Known> Relocaliser::match_last_keyframe(
    const types::RectifiedFrame& frame, std::uint64_t seed) const {
    const auto rough = register_keypoints(rig_, last_keypoints_, keypoints_, seed);
    if (!rough) return std::nullopt;
    Known known;
    known.T_current_reference = *rough;
    std::vector<KnownPoint> points;
    for (const types::Feature& feature : last_features_)
        points.push_back({feature.pixel, types::point_cam(rig_, feature)});
    const auto found =
        search_by_projection(rig_, last_left_, points, frame.left, known.T_current_reference);
    if (!found) return std::nullopt;
    for (types::Feature feature : *found) {
        const auto i = static_cast<std::size_t>(feature.id);
        feature.id = last_features_[i].id;
        feature.disparity_px = rig_.disparity_px((known.T_current_reference * points[i].p_cam).z());
        known.features.push_back(feature);
    }
    features::match_sparse_stereo(frame, {}, num_disparities_px_, known.features);
    return known;
}

}  // namespace divemesh::loops
