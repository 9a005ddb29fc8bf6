#include "worker/loops/search_by_projection.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "worker/features/align_patch.hpp"
#include "worker/features/plane_warp.hpp"
#include "worker/odometry/num_cells.hpp"
#include "worker/odometry/refine_pose.hpp"

namespace divemesh::loops {
namespace {

constexpr double kMinCorrelation = 0.8;
constexpr double kMinDepth_m = 0.05;
constexpr double kTolerance_px = 2.0;
constexpr std::size_t kMinFound = 20;
constexpr std::size_t kMinCells = 8;  // cells of the image with a found point
// The left image alone does not measure disparity.
const Eigen::Vector3d kLeftSigma_px(types::kFeatureSigma_px.x(), types::kFeatureSigma_px.y(), 1e4);

types::Features look_for(const types::RectifiedRig& rig,
                         const cv::Mat& from,
                         const std::vector<KnownPoint>& points,
                         const cv::Mat& to,
                         const Eigen::Isometry3d& T_to_from) {
    types::Features found;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto warp = features::plane_warp(
            rig, points[i].p_cam, features::fronto_parallel_plane(points[i].p_cam), T_to_from);
        const auto patch =
            warp ? features::Patch::read(from, points[i].pixel, *warp) : std::nullopt;
        if (!patch) continue;
        const auto there = patch->align(to, rig.pixel(T_to_from * points[i].p_cam));
        if (!there || there->correlation < kMinCorrelation) continue;
        found.push_back({static_cast<std::int64_t>(i), there->pixel, 0.0});
    }
    return found;
}

Eigen::Isometry3d refined(const types::RectifiedRig& rig,
                          const std::vector<KnownPoint>& points,
                          const types::Features& found,
                          const Eigen::Isometry3d& T_to_from) {
    odometry::PointPairs pairs;
    for (const types::Feature& feature : found) {
        odometry::PointPair pair;
        pair.p_previous = points[static_cast<std::size_t>(feature.id)].p_cam;
        pair.previous_px = types::project_px(rig, pair.p_previous);
        pair.current_px << feature.pixel, rig.disparity_px((T_to_from * pair.p_previous).z());
        pair.current_sigma_px = kLeftSigma_px;
        pairs.push_back(pair);
    }
    return odometry::refine_pose(rig, pairs, {T_to_from, std::nullopt, 0.0}).T_current_previous;
}

types::Features find_inliers(const types::RectifiedRig& rig,
                             const std::vector<KnownPoint>& points,
                             const types::Features& found,
                             const Eigen::Isometry3d& T_to_from) {
    types::Features result;
    for (const types::Feature& feature : found) {
        const Eigen::Vector3d p_to = T_to_from * points[static_cast<std::size_t>(feature.id)].p_cam;
        if (p_to.z() > kMinDepth_m && (rig.pixel(p_to) - feature.pixel).norm() < kTolerance_px)
            result.push_back(feature);
    }
    return result;
}

std::size_t num_cells_of(const types::RectifiedRig& rig, const types::Features& features) {
    return odometry::num_cells(
        rig, features, [](const types::Feature& feature) { return feature.pixel; });
}

}  // namespace

void refine_coarse_to_fine(const types::RectifiedRig& rig,
                           const cv::Mat& from,
                           const std::vector<KnownPoint>& points,
                           const cv::Mat& to,
                           int num_halvings,
                           Eigen::Isometry3d& T_to_from) {
    if (num_halvings == 0) return;
    types::RectifiedRig half = rig;
    half.width_px = (rig.width_px + 1) / 2;
    half.height_px = (rig.height_px + 1) / 2;
    half.focal_px = 0.5 * rig.focal_px;
    half.cx_px = 0.5 * rig.cx_px;
    half.cy_px = 0.5 * rig.cy_px;
    cv::Mat half_from;
    cv::Mat half_to;
    cv::pyrDown(from, half_from);
    cv::pyrDown(to, half_to);
    std::vector<KnownPoint> half_points = points;
    for (KnownPoint& point : half_points) point.pixel *= 0.5;
    refine_coarse_to_fine(half, half_from, half_points, half_to, num_halvings - 1, T_to_from);

    const types::Features found = look_for(half, half_from, half_points, half_to, T_to_from);
    if (found.size() < kMinFound) return;
    const Eigen::Isometry3d nearer = refined(half, half_points, found, T_to_from);
    if (2 * find_inliers(half, half_points, found, nearer).size() > found.size())
        T_to_from = nearer;
}

std::optional<types::Features> search_by_projection(const types::RectifiedRig& rig,
                                                    const cv::Mat& from,
                                                    const std::vector<KnownPoint>& points,
                                                    const cv::Mat& to,
                                                    Eigen::Isometry3d& T_to_from) {
    types::Features found;
    for (int sweep = 0; sweep < 2; ++sweep) {
        found = look_for(rig, from, points, to, T_to_from);
        for (int pass = 0; pass < 2; ++pass) {
            if (found.size() < kMinFound) return std::nullopt;
            T_to_from = refined(rig, points, found, T_to_from);
            found = find_inliers(rig, points, found, T_to_from);
        }
    }
    if (found.size() < kMinFound || num_cells_of(rig, found) < kMinCells) return std::nullopt;
    return found;
}

}  // namespace divemesh::loops
