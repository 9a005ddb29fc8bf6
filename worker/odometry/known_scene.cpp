#include "worker/odometry/known_scene.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <unordered_set>
#include <vector>

#include "worker/odometry/support.hpp"
#include "worker/stats/ratio.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::int64_t kMinAge_ns = 150'000'000;  // until a feature counts as known
constexpr std::int64_t kMaxUnseen_ns = 3'000'000'000;
constexpr double kStays_px = 1.5;  // from the first position, in the left image
constexpr std::size_t kMinKnown = 5;
// Share of the known features in sight that have to be inliers, relative to that of the others.
constexpr double kMinRelativeShare = 0.3;
constexpr double kMinShareOfPairs = 0.75;
constexpr double kNear = 0.08;    // of the image width: features on the same part of the image
constexpr double kInFront = 0.8;  // of the known depth
constexpr std::size_t kMinCompared = 8;

std::unordered_set<std::int64_t> ids_of(const PointPairs& pairs) {
    std::unordered_set<std::int64_t> ids;
    for (const PointPair& pair : pairs) ids.insert(pair.id);
    return ids;
}

}  // namespace

void KnownScene::update(const PointPairs& pairs,
                        const Registration& vision,
                        const Eigen::Isometry3d& T_world_previous,
                        std::int64_t before_ns,
                        std::int64_t now_ns) {
    if (!vision.found) return;
    const Eigen::Isometry3d T_current_world =
        vision.T_current_previous * T_world_previous.inverse();
    const auto inliers = ids_of(vision.inliers);
    for (const PointPair& pair : pairs) {
        if (!inliers.contains(pair.id)) {
            points_.erase(pair.id);
            continue;
        }
        const auto [at, fresh] = points_.try_emplace(
            pair.id, Point{T_world_previous * pair.p_previous, before_ns, now_ns, false});
        Point& point = at->second;
        point.last_ns = now_ns;
        if (!stays(point, pair, T_current_world))
            point = {T_world_previous * pair.p_previous, before_ns, now_ns, false};
        point.known = now_ns - point.first_ns >= kMinAge_ns;
    }
    std::erase_if(points_,
                  [&](const auto& at) { return now_ns - at.second.last_ns > kMaxUnseen_ns; });
}

bool KnownScene::stays(const Point& point,
                       const PointPair& pair,
                       const Eigen::Isometry3d& T_current_world) const {
    const Eigen::Vector3d p_cam = T_current_world * point.p_world;
    return p_cam.z() > types::RectifiedRig::kMinDepth_m &&
           (rig_.pixel(p_cam) - pair.current_px.head<2>()).norm() < kStays_px;
}

bool KnownScene::knows(std::int64_t id) const {
    const auto at = points_.find(id);
    return at != points_.end() && at->second.known;
}

PointPairs KnownScene::known(const PointPairs& pairs) const {
    PointPairs result;
    std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(result), [&](const PointPair& p) {
        return knows(p.id);
    });
    return result;
}

bool KnownScene::contradicts(const types::Features& previous,
                             const PointPairs& pairs,
                             const Registration& vision) const {
    const std::size_t num_known = known(pairs).size();
    if (num_known >= kMinKnown &&
        stats::ratio(known(vision.inliers).size(), num_known) < kMinShareOfPairs)
        return true;
    const auto inliers = ids_of(vision.inliers);
    std::array<std::size_t, 2> num_in_sight = {};  // of other features, of known ones
    std::array<std::size_t, 2> num_inliers = {};
    for (const types::Feature& feature : previous) {
        if (!types::has_depth(feature) ||
            !rig_.is_in_sight(vision.T_current_previous * types::point_cam(rig_, feature)))
            continue;
        const auto kind = static_cast<std::size_t>(knows(feature.id));
        ++num_in_sight[kind];
        if (inliers.contains(feature.id)) ++num_inliers[kind];
    }
    return num_in_sight[1] >= kMinKnown && num_inliers[0] > num_inliers[1] &&
           stats::ratio(num_inliers[1], num_in_sight[1]) <
               kMinRelativeShare * stats::ratio(num_inliers[0], num_in_sight[0]);
}

bool KnownScene::confirms(const Registration& vision,
                          const std::optional<Eigen::Isometry3d>& expected) const {
    if (!vision.found || !expected) return false;
    const PointPairs inliers = known(vision.inliers);
    return inliers.size() >= kMinInliers && is_near_prediction(rig_, inliers, *expected);
}

bool KnownScene::is_hidden_behind(const Registration& vision,
                                  const Eigen::Isometry3d& T_world_previous) const {
    if (known(vision.inliers).size() >= kMinKnown) return false;
    const Eigen::Isometry3d T_previous_world = T_world_previous.inverse();
    std::vector<Eigen::Vector3d> scene;  // u, v, depth
    for (const auto& [id, point] : points_) {
        const Eigen::Vector3d p_cam = T_previous_world * point.p_world;
        if (!point.known || !rig_.is_in_sight(p_cam)) continue;
        const Eigen::Vector2d pixel = rig_.pixel(p_cam);
        scene.emplace_back(pixel.x(), pixel.y(), p_cam.z());
    }
    std::size_t num_compared = 0;
    std::size_t num_in_front = 0;
    for (const PointPair& pair : vision.inliers) {
        const auto distance_px = [&](const Eigen::Vector3d& p) {
            return (p.head<2>() - pair.previous_px.head<2>()).norm();
        };
        const auto nearest = std::min_element(
            scene.begin(), scene.end(), [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
                return distance_px(a) < distance_px(b);
            });
        if (nearest == scene.end() || distance_px(*nearest) > kNear * rig_.width_px) continue;
        ++num_compared;
        if (pair.p_previous.z() < kInFront * nearest->z()) ++num_in_front;
    }
    return num_compared >= kMinCompared && 2 * num_in_front > num_compared;
}

}  // namespace divemesh::odometry
