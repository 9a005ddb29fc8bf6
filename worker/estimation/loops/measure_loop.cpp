#include "worker/estimation/loops/measure_loop.hpp"

#include "worker/estimation/loops/match_views.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::worker {
namespace {

constexpr double kSigmaShare = 0.01;  // of the depth: what a loop's translation is good for
constexpr double kMostTurn_rad = 0.02;
constexpr std::size_t kMostPictures = 16;

double median_depth_m(const std::vector<KnownPoint>& points) {
    std::vector<double> depths_m;
    for (const KnownPoint& point : points) depths_m.push_back(point.p_cam.z());
    return upper_median(std::move(depths_m));
}

// The same motion, measured by the points of either.
bool same(const Eigen::Isometry3d& T_to_from, const Eigen::Isometry3d& T_from_to, double sigma_m) {
    const Eigen::Isometry3d round = T_to_from * T_from_to;
    return round.translation().norm() < 5.0 * sigma_m &&
           Eigen::AngleAxisd(round.linear()).angle() < kMostTurn_rad;
}

}  // namespace

LoopMeter::LoopMeter(const RectifiedRig& rig,
                     const std::vector<Keyframe>& keyframes,
                     const std::vector<Landmark>& landmarks,
                     const KeyframeStore& store)
    : rig_(rig),
      keyframes_(keyframes),
      landmarks_(landmarks),
      store_(store),
      views_(store, keyframes),
      seen_(keyframes.size()) {
    for (std::size_t i = 0; i < landmarks.size(); ++i)
        for (const LandmarkObservation& observation : landmarks[i].observations)
            seen_[static_cast<std::size_t>(observation.keyframe)].push_back({i, observation});
}

std::optional<Loop> LoopMeter::recognise(std::size_t from, std::size_t to, std::uint64_t seed) {
    const auto T_to_from = register_views(rig_, views_[from], views_[to], seed);
    if (!T_to_from) return std::nullopt;
    return measure(from, to, *T_to_from);
}

std::optional<Loop> LoopMeter::measure(std::size_t from,
                                       std::size_t to,
                                       const Eigen::Isometry3d& T_to_from,
                                       int num_halvings) {
    const auto points_from = known_points(from);
    const auto points_to = known_points(to);
    if (points_from.empty() || points_to.empty()) return std::nullopt;
    const cv::Mat picture_from = picture(from);
    const cv::Mat picture_to = picture(to);
    Eigen::Isometry3d forward = T_to_from;
    approach(rig_, picture_from, points_from, picture_to, num_halvings, forward);
    const auto in_to = observe_again(rig_, picture_from, points_from, picture_to, forward);
    if (!in_to) return std::nullopt;
    Eigen::Isometry3d backward = forward.inverse();
    const auto in_from = observe_again(rig_, picture_to, points_to, picture_from, backward);
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

cv::Mat LoopMeter::picture(std::size_t keyframe) {
    const auto known = pictures_.find(keyframe);
    if (known != pictures_.end()) return known->second;
    if (pictures_.size() >= kMostPictures) pictures_.erase(pictures_.begin());
    return pictures_.emplace(keyframe, store_.read_left(keyframes_[keyframe].frame_index))
        .first->second;
}

std::vector<KnownPoint> LoopMeter::known_points(std::size_t keyframe) const {
    const Eigen::Isometry3d T_cam_world = keyframes_[keyframe].T_world_cam.inverse();
    std::vector<KnownPoint> points;
    for (const Seen& seen : seen_[keyframe])
        points.push_back({{seen.observation.u_px, seen.observation.v_px},
                          T_cam_world * landmarks_[seen.landmark].p_world});
    return points;
}

std::vector<Reobservation> LoopMeter::reobservations(const Features& found,
                                                     std::size_t of,
                                                     std::size_t in) const {
    std::vector<Reobservation> result;
    for (const Feature& feature : found)
        result.push_back({seen_[of][static_cast<std::size_t>(feature.id)].landmark,
                          {static_cast<std::int32_t>(in),
                           static_cast<float>(feature.pixel.x()),
                           static_cast<float>(feature.pixel.y()),
                           static_cast<float>(feature.disparity_px)}});
    return result;
}

}  // namespace divemesh::worker
