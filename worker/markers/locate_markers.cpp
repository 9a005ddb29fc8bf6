#include "worker/markers/locate_markers.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "worker/base/rotation_vector.hpp"
#include "worker/markers/triangulate_corners.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::markers {
namespace {

constexpr double kMaxDisagreement_px = 6.0;  // between views of one tag at first
constexpr double kMinGate_px = 0.75;  // rms of a view over its corners that is always accepted
constexpr double kGate = 3.0;         // in medians
constexpr std::size_t kMaxHypotheses = 40;

std::vector<double> path_lengths(const std::vector<types::Keyframe>& keyframes) {
    std::vector<double> lengths(keyframes.size(), 0.0);
    for (std::size_t i = 1; i < keyframes.size(); ++i) {
        const bool joined = keyframes[i].segment == keyframes[i - 1].segment;
        const Eigen::Vector3d way =
            keyframes[i].T_world_cam.translation() - keyframes[i - 1].T_world_cam.translation();
        lengths[i] = lengths[i - 1] + (joined ? way.norm() : 0.0);
    }
    return lengths;
}

// Returns the views that agree with a place triangulated from two of them; the place with the most
// inliers wins.
std::vector<CornerView> inlier_views(const std::vector<CornerView>& views) {
    std::vector<CornerView> best;
    const std::size_t step = std::max<std::size_t>(1, views.size() / (kMaxHypotheses / 2));
    for (std::size_t i = 0; i < views.size(); i += step) {
        for (const std::size_t partner : {i + 1, i + views.size() / 2}) {
            const CornerView& other = views[partner % views.size()];
            const auto corners = triangulate_corners({views[i], other});
            if (!corners) continue;
            std::vector<CornerView> agreeing;
            for (const CornerView& view : views)
                if (view.rms_px(*corners) < kMaxDisagreement_px) agreeing.push_back(view);
            if (agreeing.size() > best.size()) best = std::move(agreeing);
        }
    }
    return best;
}

int num_keyframes(const std::vector<CornerView>& views) {
    int num = 0;
    for (std::size_t i = 0; i < views.size(); ++i)
        if (i == 0 || views[i].keyframe != views[i - 1].keyframe) ++num;
    return num;
}

// Triangulates by least squares, removes outlier views, and repeats.
std::optional<Corners> settle(std::vector<CornerView>& views) {
    for (int round = 0; round < 3; ++round) {
        if (num_keyframes(views) < kMinMarkerKeyframes) return std::nullopt;
        auto corners = triangulate_corners(views);
        if (!corners) return std::nullopt;
        std::vector<double> errors_px;
        errors_px.reserve(views.size());
        for (const CornerView& view : views) errors_px.push_back(view.rms_px(*corners));
        const double max_px = std::max(kMinGate_px, kGate * stats::upper_median(errors_px));
        const auto num_out = std::erase_if(
            views, [&](const CornerView& view) { return view.rms_px(*corners) > max_px; });
        if (num_out == 0) return corners;
    }
    if (num_keyframes(views) < kMinMarkerKeyframes) return std::nullopt;
    return triangulate_corners(views);
}

Eigen::Isometry3d pose_of(const Corners& corners) {
    const Eigen::Vector3d right = corners[1] - corners[0] + corners[2] - corners[3];
    const Eigen::Vector3d up = corners[3] - corners[0] + corners[2] - corners[1];
    const Eigen::Vector3d out = right.cross(up).normalized();
    // The square's axes, rotated as little as possible from both edges.
    const Eigen::Vector3d middle = (right.normalized() + up.normalized()).normalized();
    const Eigen::Vector3d aside = (right.normalized() - up.normalized()).normalized();
    Eigen::Isometry3d T_world_marker = Eigen::Isometry3d::Identity();
    T_world_marker.linear().col(0) = (middle + aside).normalized();
    T_world_marker.linear().col(2) = out;
    T_world_marker.linear().col(1) = out.cross(T_world_marker.linear().col(0));
    T_world_marker.translation() = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    return T_world_marker;
}

const types::PoseCovariance& covariance_at(const types::CovarianceTrack& track,
                                           std::int64_t timestamp_ns) {
    const auto at = std::lower_bound(track.begin(),
                                     track.end(),
                                     timestamp_ns,
                                     [](const types::PoseCovariance& one, std::int64_t time) {
                                         return one.timestamp_ns < time;
                                     });
    return at == track.end() ? track.back() : *at;
}

// Returns the mean over the views of the covariance that the pose errors give the marker's centre.
Eigen::Matrix3d drift_at(const std::vector<CornerView>& views,
                         const Eigen::Vector3d& p_world,
                         const MarkerWorld& world) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    if (world.covariances.empty() || world.trajectory.empty()) return sum;
    const Eigen::Matrix3d R_world_first = world.trajectory.front().T_world_imu.linear();
    for (const CornerView& view : views) {
        const types::Keyframe& keyframe = world.keyframes[view.keyframe];
        const auto& covariance = covariance_at(world.covariances, keyframe.timestamp_ns);
        const Eigen::Matrix3d arm = base::cross_matrix(
            R_world_first.transpose() * (p_world - keyframe.T_world_cam.translation()));
        sum += covariance.position_m2 + arm * covariance.rotation_rad2 * arm.transpose();
    }
    return R_world_first * (sum / static_cast<double>(views.size())) * R_world_first.transpose();
}

class MarkerLocator {
public:
    explicit MarkerLocator(const MarkerWorld& world)
        : world_(world), path_m_(path_lengths(world.keyframes)) {}

    std::optional<Marker> locate(const std::vector<const TagView*>& views) const {
        std::vector<CornerView> seen;
        seen.reserve(views.size());
        for (const TagView* view : views) seen.push_back(corner_view(*view));
        std::vector<CornerView> kept = inlier_views(seen);
        const auto corners = settle(kept);
        if (!corners) return std::nullopt;
        Marker marker;
        marker.id = views.front()->id;
        marker.segment = world_.keyframes[views.front()->keyframe].segment;
        marker.num_views = static_cast<int>(kept.size());
        marker.num_keyframes = num_keyframes(kept);
        marker.num_rejected_views = static_cast<int>(seen.size() - kept.size());
        marker.corners_world = *corners;
        marker.T_world_marker = pose_of(*corners);
        const auto fit = corner_covariance(kept, *corners);
        marker.reprojection_rms_px = fit.rms_px;
        marker.corner_covariance_m2 = fit.covariance_m2;
        const Eigen::Vector3d middle = marker.T_world_marker.translation();
        marker.drift_covariance_m2 = drift_at(kept, middle, world_);
        add_distances(kept, marker);
        return marker;
    }

private:
    CornerView corner_view(const TagView& view) const {
        CornerView result;
        result.keyframe = view.keyframe;
        result.focal_px = world_.rig.focal_px;
        result.principal_px = {world_.rig.cx_px, world_.rig.cy_px};
        result.T_cam_world = pose_at_row(view).inverse();
        if (view.is_right)
            result.T_cam_world.pretranslate(Eigen::Vector3d(-world_.rig.baseline_m, 0, 0));
        result.corners_px = view.corners_px;
        return result;
    }

    // Returns the left camera's pose when the row of the tag's centre was read.
    Eigen::Isometry3d pose_at_row(const TagView& view) const {
        const types::Keyframe& keyframe = world_.keyframes[view.keyframe];
        if (!world_.shutter) return keyframe.T_world_cam;
        Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
        for (const Eigen::Vector2d& corner_px : view.corners_px)
            centre_px += corner_px / static_cast<double>(dive::kNumTagCorners);
        return keyframe.T_world_cam *
               world_.shutter->motion_until_row(keyframe.frame_index, centre_px);
    }

    void add_distances(const std::vector<CornerView>& views, Marker& marker) const {
        std::vector<double> ranges_m;
        double path_m = 0.0;
        for (const CornerView& view : views) {
            ranges_m.push_back((view.T_cam_world * marker.T_world_marker.translation()).norm());
            path_m += path_m_[view.keyframe];
        }
        marker.range_m = stats::upper_median(std::move(ranges_m));
        marker.pixel_m = marker.range_m / world_.rig.focal_px;
        marker.path_m = path_m / static_cast<double>(views.size());
    }

    const MarkerWorld& world_;
    std::vector<double> path_m_;
};

}  // namespace

std::vector<Marker> locate_markers(std::vector<TagView> views, const MarkerWorld& world) {
    std::sort(views.begin(), views.end(), [](const TagView& a, const TagView& b) {
        return std::tie(a.keyframe, a.is_right) < std::tie(b.keyframe, b.is_right);
    });
    std::map<std::pair<std::int32_t, int>, std::vector<const TagView*>> by_marker;
    for (const TagView& view : views)
        by_marker[{world.keyframes[view.keyframe].segment, view.id}].push_back(&view);
    const MarkerLocator locator(world);
    std::vector<Marker> markers;
    for (const auto& [key, of_marker] : by_marker)
        if (auto marker = locator.locate(of_marker)) markers.push_back(std::move(*marker));
    return markers;
}

double drift_rate(const MarkerWorld& world) {
    if (world.covariances.empty() || world.keyframes.empty()) return 0.0;
    const auto path_m = path_lengths(world.keyframes);
    constexpr double kBegun = 0.05;  // share of the path: nearer to the start the quotient is noise
    double rate = 0.0;
    for (std::size_t i = 0; i < path_m.size(); ++i)
        if (path_m[i] > kBegun * path_m.back())
            rate = std::max(rate,
                            covariance_at(world.covariances, world.keyframes[i].timestamp_ns)
                                    .position_m2.trace() /
                                path_m[i]);
    return rate;
}

}  // namespace divemesh::markers
