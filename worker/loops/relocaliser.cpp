#include "worker/loops/relocaliser.hpp"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "worker/features/match_sparse_stereo.hpp"
#include "worker/loops/search_by_projection.hpp"

namespace divemesh::loops {
namespace {

constexpr std::size_t kNumKeyframes = 3;  // further ones are found as loops, after tracking

// Confirmed features of a keyframe that are enough to recognise a frame, or to contradict it.
constexpr std::size_t kMinConfirmed = 5;

// Returns the keypoints by which loops are found. Their disparities are measured by searching along
// the rows of the right image.
features::DescribedKeypoints loop_keypoints(const types::RectifiedFrame& frame,
                                            int num_disparities_px) {
    features::DescribedKeypoints view = features::describe_keypoints(frame.left);
    std::erase_if(view, [&](const features::DescribedKeypoint& point) {
        return !frame.shows_scene({point.u_px, point.v_px});
    });
    types::Features corners;
    for (const features::DescribedKeypoint& point : view)
        corners.push_back({0, {point.u_px, point.v_px}, 0.0});
    features::match_sparse_stereo(frame, {}, num_disparities_px, corners);
    for (std::size_t i = 0; i < view.size(); ++i)
        view[i].disparity_px = static_cast<float>(corners[i].disparity_px);
    return view;
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

Relocaliser::Relocaliser(const types::RectifiedRig& rig, bool close_loops, int num_disparities_px)
    : rig_(rig), close_loops_(close_loops), num_disparities_px_(num_disparities_px) {}

std::optional<Eigen::Isometry3d> Relocaliser::register_to_previous(
    const types::RectifiedFrame& frame, const MotionPrior& prior, std::uint64_t seed) {
    if (!previous_) return std::nullopt;
    return register_wide_baseline(
        rig_, described(*previous_), described(current(frame)), prior, seed);
}

std::optional<Relocaliser::Recognised> Relocaliser::recognise(
    const types::RectifiedFrame& frame,
    const Eigen::Isometry3d& predicted_T_world_cam,
    std::uint64_t seed) {
    for (KeptKeyframe& keyframe : keyframes_)
        if (auto recognised = recognise_by(keyframe, frame, predicted_T_world_cam, seed))
            return recognised;
    return std::nullopt;
}

std::optional<Relocaliser::Recognised> Relocaliser::recognise_by(
    KeptKeyframe& keyframe,
    const types::RectifiedFrame& frame,
    const Eigen::Isometry3d& predicted_T_world_cam,
    std::uint64_t seed) {
    const Eigen::Isometry3d predicted = predicted_T_world_cam.inverse() * keyframe.T_world_cam;
    if (auto recognised = recognise_from(keyframe, frame, predicted)) return recognised;
    const auto rough = register_wide_baseline(
        rig_, described(keyframe.view), described(current(frame)), {predicted, std::nullopt}, seed);
    if (!rough) return std::nullopt;
    return recognise_from(keyframe, frame, *rough);
}

// Recognises the frame from a pose that is accurate to some pixels.
std::optional<Relocaliser::Recognised> Relocaliser::recognise_from(
    const KeptKeyframe& keyframe,
    const types::RectifiedFrame& frame,
    Eigen::Isometry3d T_current_keyframe) const {
    types::Features features = keyframe.features;
    std::erase_if(features, [&](const types::Feature& feature) {
        return keyframe.missed.contains(feature.id) && !keyframe.confirmed.contains(feature.id);
    });
    std::vector<KnownPoint> points;
    points.reserve(features.size());
    for (const types::Feature& feature : features)
        points.push_back({feature.pixel, types::point_cam(rig_, feature)});
    const auto found = search_by_projection(
        rig_, keyframe.view.frame.left, points, frame.left, T_current_keyframe);
    if (!found) return std::nullopt;
    Recognised recognised;
    recognised.T_world_keyframe = keyframe.T_world_cam;
    recognised.T_world_cam = keyframe.T_world_cam * T_current_keyframe.inverse();
    for (types::Feature feature : *found) {
        const auto i = static_cast<std::size_t>(feature.id);
        feature.id = features[i].id;
        feature.disparity_px = rig_.disparity_px((T_current_keyframe * points[i].p_cam).z());
        recognised.in_keyframe.push_back(features[i]);
        recognised.features.push_back(feature);
    }
    if (contradicts(keyframe, T_current_keyframe, recognised.features)) return std::nullopt;
    features::match_sparse_stereo(frame, {}, num_disparities_px_, recognised.features);
    return recognised;
}

// Returns true if the confirmed features of a keyframe speak against a motion to the current frame:
// it leaves enough of them in sight, but was found by others.
bool Relocaliser::contradicts(const KeptKeyframe& keyframe,
                              const Eigen::Isometry3d& T_current_keyframe,
                              const types::Features& found) const {
    std::size_t num_in_sight = 0;
    for (const types::Feature& feature : keyframe.features)
        if (keyframe.confirmed.contains(feature.id) &&
            rig_.is_in_sight(T_current_keyframe * types::point_cam(rig_, feature)))
            ++num_in_sight;
    const auto num_found = static_cast<std::size_t>(
        std::count_if(found.begin(), found.end(), [&](const types::Feature& feature) {
            return keyframe.confirmed.contains(feature.id);
        }));
    return num_in_sight >= kMinConfirmed && num_found < kMinConfirmed &&
           4 * num_found < found.size();
}

bool Relocaliser::relocalise(const types::RectifiedFrame& frame,
                             std::uint64_t seed,
                             types::Features& features,
                             odometry::MotionModel& motion) {
    if (!std::exchange(lost_, false)) return false;
    const auto known = recognise(frame, motion.T_world_cam(), seed);
    if (!known) return false;
    motion.correct(known->T_world_cam);
    join(known->features, features);
    return true;
}

std::optional<features::DescribedKeypoints> Relocaliser::keep(
    const types::RectifiedFrame& frame,
    const types::Features& features,
    const Eigen::Isometry3d& T_world_cam) {
    if (keyframes_.size() == kNumKeyframes) keyframes_.pop_back();
    keyframes_.push_front({current(frame), features, {}, {}, T_world_cam});
    std::erase_if(keyframes_.front().features,
                  [](const types::Feature& feature) { return !types::has_depth(feature); });
    if (!close_loops_) return std::nullopt;
    return loop_keypoints(frame, num_disparities_px_);
}

void Relocaliser::confirm(const odometry::PointPairs& inliers,
                          const Eigen::Isometry3d& T_world_cam) {
    std::unordered_set<std::int64_t> followed;
    for (const odometry::PointPair& pair : inliers) followed.insert(pair.id);
    for (KeptKeyframe& keyframe : keyframes_) {
        const Eigen::Isometry3d T_cam_keyframe = T_world_cam.inverse() * keyframe.T_world_cam;
        for (const types::Feature& feature : keyframe.features)
            if (followed.contains(feature.id))
                keyframe.confirmed.insert(feature.id);
            else if (rig_.is_in_sight(T_cam_keyframe * types::point_cam(rig_, feature)))
                keyframe.missed.insert(feature.id);
    }
}

void Relocaliser::pass(const types::RectifiedFrame& frame) {
    previous_ = current(frame);
    current_.reset();
}

const SiftKeypoints& Relocaliser::described(View& view) const {
    if (!view.keypoints)
        view.keypoints =
            std::make_shared<const SiftKeypoints>(sift_keypoints(view.frame, num_disparities_px_));
    return *view.keypoints;
}

Relocaliser::View& Relocaliser::current(const types::RectifiedFrame& frame) {
    if (!current_) current_ = View{frame, nullptr};
    return *current_;
}

}  // namespace divemesh::loops
