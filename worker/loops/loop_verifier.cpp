#include "worker/loops/loop_verifier.hpp"

#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/features/described_keypoints.hpp"
#include "worker/loops/match_keypoints.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::loops {
namespace {

constexpr double kSigmaShare = 0.01;  // of the depth: sigma of a loop's translation
constexpr double kMaxRotation_rad = 0.02;
constexpr std::size_t kMaxImages = 16;

double median_depth_m(const std::vector<KnownPoint>& points) {
    std::vector<double> depths_m;
    depths_m.reserve(points.size());
    for (const KnownPoint& point : points) depths_m.push_back(point.p_cam.z());
    return stats::upper_median(std::move(depths_m));
}

// Returns true if both directions measured the same motion.
bool same(const Eigen::Isometry3d& T_to_from, const Eigen::Isometry3d& T_from_to, double sigma_m) {
    const Eigen::Isometry3d round = T_to_from * T_from_to;
    return round.translation().norm() < 5.0 * sigma_m &&
           base::angle_rad(round.linear()) < kMaxRotation_rad;
}

}  // namespace

LoopVerifier::LoopVerifier(const types::RectifiedRig& rig,
                           const std::vector<types::Keyframe>& keyframes,
                           const std::vector<types::Landmark>& landmarks,
                           const keyframes::KeyframeStore& store)
    : rig_(rig),
      keyframes_(keyframes),
      landmarks_(landmarks),
      store_(store),
      views_(store, keyframes),
      seen_(keyframes.size()) {
    for (std::size_t i = 0; i < landmarks.size(); ++i)
        for (const types::LandmarkObservation& observation : landmarks[i].observations)
            seen_[static_cast<std::size_t>(observation.keyframe)].push_back({i, observation});
}

std::optional<Loop> LoopVerifier::verify(std::size_t from, std::size_t to, std::uint64_t seed) {
    const auto T_to_from = register_keypoints(rig_, views_[from], views_[to], seed);
    if (!T_to_from) return std::nullopt;
    // The pose is accurate to some pixels of the images as described.
    const double scale = features::description_scale({rig_.width_px, rig_.height_px});
    return measure(from, to, *T_to_from, static_cast<int>(std::lround(std::log2(scale))));
}

std::optional<Loop> LoopVerifier::measure(std::size_t from,
                                          std::size_t to,
                                          const Eigen::Isometry3d& T_to_from,
                                          int num_halvings) {
    const auto points_from = known_points(from);
    const auto points_to = known_points(to);
    if (points_from.empty() || points_to.empty()) return std::nullopt;
    const cv::Mat image_from = image(from);
    const cv::Mat image_to = image(to);
    Eigen::Isometry3d forward = T_to_from;
    refine_coarse_to_fine(rig_, image_from, points_from, image_to, num_halvings, forward);
    const auto in_to = search_by_projection(rig_, image_from, points_from, image_to, forward);
    if (!in_to) return std::nullopt;
    Eigen::Isometry3d backward = forward.inverse();
    const auto in_from = search_by_projection(rig_, image_to, points_to, image_from, backward);
    const double sigma_m = kSigmaShare * median_depth_m(points_from);
    if (!in_from || !same(forward, backward, sigma_m)) return std::nullopt;

    Loop loop;
    loop.from = from;
    loop.to = to;
    loop.T_from_to = forward.inverse();
    loop.sigma_m = sigma_m;
    loop.reobservations = reobservations(*in_to, from, to);
    const auto other = reobservations(*in_from, to, from);
    loop.reobservations.insert(loop.reobservations.end(), other.begin(), other.end());
    return loop;
}

cv::Mat LoopVerifier::image(std::size_t keyframe) {
    const auto known = images_.find(keyframe);
    if (known != images_.end()) return known->second;
    if (images_.size() >= kMaxImages) images_.erase(images_.begin());
    return images_.emplace(keyframe, store_.read_left(keyframes_[keyframe].frame_index))
        .first->second;
}

std::vector<KnownPoint> LoopVerifier::known_points(std::size_t keyframe) const {
    const Eigen::Isometry3d T_cam_world = keyframes_[keyframe].T_world_cam.inverse();
    std::vector<KnownPoint> points;
    for (const Seen& seen : seen_[keyframe])
        points.push_back({{seen.observation.u_px, seen.observation.v_px},
                          T_cam_world * landmarks_[seen.landmark].p_world});
    return points;
}

std::vector<Reobservation> LoopVerifier::reobservations(const types::Features& found,
                                                        std::size_t of,
                                                        std::size_t in) const {
    std::vector<Reobservation> result;
    result.reserve(found.size());
    for (const types::Feature& feature : found)
        result.push_back({seen_[of][static_cast<std::size_t>(feature.id)].landmark,
                          {static_cast<std::int32_t>(in),
                           static_cast<float>(feature.pixel.x()),
                           static_cast<float>(feature.pixel.y()),
                           static_cast<float>(feature.disparity_px)}});
    return result;
}

}  // namespace divemesh::loops
