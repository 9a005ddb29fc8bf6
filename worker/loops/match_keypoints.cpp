#include "worker/loops/match_keypoints.hpp"

#include <vector>

#include "worker/loops/nearest_two.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/odometry/register_points.hpp"

namespace divemesh::loops {
namespace {

constexpr int kMaxHammingDistance = 72;
constexpr double kRatio = 0.85;
// Max distance of a match from where the motion puts it, in the images as described: corners are at
// whole pixels of their level.
constexpr double kTolerance_px = 4.0;
constexpr std::size_t kMinAgreeing = 12;
constexpr double kSigma_px = 1.0;  // of a corner's position, on its own level

using Nearest = NearestTwo<int>;  // by Hamming distance
constexpr int kFarthest = 257;

bool distinct(const Nearest& nearest) {
    return nearest.first <= kMaxHammingDistance && nearest.first < kRatio * nearest.second;
}

types::Feature feature(const features::DescribedKeypoint& point) {
    return {0, {point.u_px, point.v_px}, point.disparity_px};
}

}  // namespace

odometry::PointPairs match_keypoints(const types::RectifiedRig& rig,
                                     const features::DescribedKeypoints& a,
                                     const features::DescribedKeypoints& b) {
    std::vector<Nearest> of_a(a.size(), Nearest(kFarthest));
    std::vector<Nearest> of_b(b.size(), Nearest(kFarthest));
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (std::size_t j = 0; j < b.size(); ++j) {
            const int distance = features::hamming_distance(a[i].descriptor, b[j].descriptor);
            of_a[i].offer(static_cast<int>(j), distance);
            of_b[j].offer(static_cast<int>(i), distance);
        }
    }
    odometry::PointPairs pairs;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (!distinct(of_a[i])) continue;
        const auto j = static_cast<std::size_t>(of_a[i].index);
        if (of_b[j].index != static_cast<int>(i)) continue;
        if (a[i].disparity_px <= 0.0F || b[j].disparity_px <= 0.0F) continue;
        odometry::PointPair pair;
        pair.id = static_cast<std::int64_t>(i);
        pair.previous_px = types::measurement_px(feature(a[i]));
        pair.current_px = types::measurement_px(feature(b[j]));
        pair.previous_sigma_px.setConstant(kSigma_px * a[i].scale);
        pair.p_previous = types::point_cam(rig, feature(a[i]));
        pair.p_current = types::point_cam(rig, feature(b[j]));
        pairs.push_back(pair);
    }
    return pairs;
}

std::optional<Eigen::Isometry3d> register_keypoints(const types::RectifiedRig& rig,
                                                    const features::DescribedKeypoints& a,
                                                    const features::DescribedKeypoints& b,
                                                    std::uint64_t seed) {
    const double tolerance_px =
        kTolerance_px * features::description_scale({rig.width_px, rig.height_px});
    const odometry::Registration found =
        odometry::register_points(rig, match_keypoints(rig, a, b), tolerance_px, seed);
    if (!found.found || found.inliers.size() < kMinAgreeing) return std::nullopt;
    return odometry::refine_pose(rig, found.inliers, {found.T_current_previous, std::nullopt, 0.0})
        .T_current_previous;
}

}  // namespace divemesh::loops
