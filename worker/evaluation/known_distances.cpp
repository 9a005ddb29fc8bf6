#include "worker/evaluation/known_distances.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/base/nearest_to_rays.hpp"
#include "worker/base/seconds.hpp"
#include "worker/camera/projection.hpp"
#include "worker/camera/right_camera_at.hpp"
#include "worker/evaluation/scaled_uncertainty.hpp"
#include "worker/evaluation/trajectory_pairs.hpp"
#include "worker/optimisation/covariance_between.hpp"
#include "worker/stats/distributions.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/summary.hpp"

namespace divemesh::evaluation {
namespace {

constexpr std::size_t kMinKeyframes = 4;
constexpr double kMinParallax = 1e-6;  // as in nearest_to_rays()
constexpr int kMaxIterations = 10;
// RMS by which the last step of a solution may move the projections of a point.
constexpr double kMaxLastStep_px = 0.01;

// A pixel, the camera that saw it, and the camera's pose.
struct View {
    types::Camera camera;
    Eigen::Isometry3d T_world_cam;
    Eigen::Vector2d pixel;
};

std::optional<Eigen::Vector2d> project_inside(const types::Camera& camera,
                                              const Eigen::Vector3d& p_cam) {
    auto pixel = camera::project(camera, p_cam);
    if (!pixel || !camera::contains(camera, *pixel)) return std::nullopt;
    // Far outside the lens's field of view the distortion polynomial folds back into the image.
    const base::Ray ray = camera::sight_ray(camera, *pixel);
    const Eigen::Vector3d there = ray.origin + (p_cam.z() - ray.origin.z()) * ray.direction;
    if ((there - p_cam).norm() > 1e-3 * p_cam.z()) return std::nullopt;
    return pixel;
}

bool is_hidden(const Eigen::Vector3d& eye,
               const Eigen::Vector3d& point,
               const MarkingInput& input) {
    const Eigen::Vector3d way = point - eye;
    const auto hit = input.reference.first_hit_m(eye.cast<float>(), way.normalized().cast<float>());
    return hit && static_cast<double>(*hit) < way.norm() - input.tolerance_m;
}

std::vector<View> views_of(const std::vector<dive::Mark>& marks,
                           const types::Rig& rig,
                           const types::Trajectory& trajectory,
                           int min_keyframes,
                           double readout_time_s) {
    std::vector<View> views;
    int num_keyframes = 0;
    for (const dive::Mark& mark : marks) {
        const auto pose_at_row = [&](const types::Camera& camera, const Eigen::Vector2d& pixel) {
            const double late_s = readout_time_s * (pixel.y() / camera.height_px - 0.5);
            return pose_at(trajectory, mark.timestamp_ns + base::to_ns(late_s));
        };
        const auto T_world_imu = pose_at_row(rig.cam0, mark.pixel_left);
        if (!T_world_imu) continue;
        ++num_keyframes;
        views.push_back({rig.cam0, *T_world_imu * rig.T_imu_cam0, mark.pixel_left});
        if (!mark.pixel_right) continue;
        const auto cam1 = camera::right_camera_at(rig, mark.timestamp_ns);
        if (const auto right = pose_at_row(cam1.camera, *mark.pixel_right))
            views.push_back({cam1.camera, *right * cam1.T_imu_cam, *mark.pixel_right});
    }
    if (num_keyframes < min_keyframes) views.clear();
    return views;
}

std::vector<base::Ray> rays_of(const std::vector<View>& views) {
    std::vector<base::Ray> rays;
    rays.reserve(views.size());
    for (const View& view : views) {
        const base::Ray ray = camera::sight_ray(view.camera, view.pixel);
        rays.push_back({view.T_world_cam * ray.origin, view.T_world_cam.linear() * ray.direction});
    }
    return rays;
}

// Reprojection error in pixels, to second order: H = J^T J, gradient J^T r, squares r^T r.
struct Reprojection {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    double squares_px2 = 0.0;
};

// Returns nullopt if the point is behind a camera.
std::optional<Reprojection> reproject(const std::vector<View>& views,
                                      const Eigen::Vector3d& point) {
    Reprojection sum;
    for (const View& view : views) {
        const Eigen::Isometry3d T_cam_world = view.T_world_cam.inverse();
        const auto pixel = camera::project(view.camera, T_cam_world * point);
        if (!pixel) return std::nullopt;
        Eigen::Matrix<double, 2, 3> J;
        constexpr double kStep_m = 1e-6;
        for (int axis = 0; axis < 3; ++axis) {
            const Eigen::Vector3d step = kStep_m * Eigen::Vector3d::Unit(axis);
            const auto ahead = camera::project(view.camera, T_cam_world * (point + step));
            const auto behind = camera::project(view.camera, T_cam_world * (point - step));
            if (!ahead || !behind) return std::nullopt;
            J.col(axis) = (*ahead - *behind) / (2.0 * kStep_m);
        }
        const Eigen::Vector2d r = view.pixel - *pixel;
        sum.H += J.transpose() * J;
        sum.gradient += J.transpose() * r;
        sum.squares_px2 += r.squaredNorm();
    }
    return sum;
}

// Returns nullopt if the rays do not determine a point or the iterations do not converge in front
// of the cameras.
std::optional<Eigen::Vector3d> located(const std::vector<View>& views) {
    auto point = base::nearest_to_rays(rays_of(views), kMinParallax);
    if (!point) return std::nullopt;
    double last_step_px = 0.0;
    for (int i = 0; i < kMaxIterations; ++i) {
        const auto at = reproject(views, *point);
        if (!at) return std::nullopt;
        const Eigen::Vector3d step = at->H.ldlt().solve(at->gradient);
        if (!step.allFinite()) return std::nullopt;
        *point += step;
        last_step_px = std::sqrt(std::max(0.0, step.dot(at->H * step)) /
                                 (2.0 * static_cast<double>(views.size())));
        if (step.norm() < 1e-9) break;
    }
    return last_step_px > kMaxLastStep_px ? std::nullopt : point;
}

// A triangulated end of a length.
struct End {
    Eigen::Vector3d p_world;
    Eigen::Matrix3d scatter_m2 = Eigen::Matrix3d::Zero();  // from the scatter of the marks
    double range_m = 0.0;                                  // mean, to the cameras
    std::int64_t timestamp_ns = 0;                         // mean of the marks
};

std::optional<End> end_of(const std::vector<dive::Mark>& marks,
                          const types::Rig& rig,
                          const types::Trajectory& path,
                          double readout_time_s) {
    const std::vector<View> views =
        views_of(marks, rig, path, static_cast<int>(kMinKeyframes), readout_time_s);
    const auto point = views.empty() ? std::nullopt : located(views);
    if (!point) return std::nullopt;
    End end{.p_world = *point};
    const auto num_views = static_cast<double>(views.size());
    if (const auto at = reproject(views, *point))
        end.scatter_m2 = at->squares_px2 / (2.0 * num_views - 3.0) * at->H.inverse();
    for (const View& view : views)
        end.range_m += (view.T_world_cam.translation() - *point).norm() / num_views;
    for (const dive::Mark& mark : marks)
        end.timestamp_ns += (mark.timestamp_ns - marks.front().timestamp_ns) / std::ssize(marks);
    end.timestamp_ns += marks.front().timestamp_ns;
    return end;
}

double max_eigenvalue(const Eigen::Matrix3d& symmetric) {
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(symmetric, Eigen::EigenvaluesOnly)
        .eigenvalues()
        .cwiseAbs()
        .maxCoeff();
}

// Returns the variance of the drift between two ends. Drift accumulates in steps, so the variances
// at two times differ by the steps in between.
double drift_variance_m2(const End& a, const End& b, const types::CovarianceTrack& covariances) {
    const types::PoseCovariance at_a =
        optimisation::covariance_between(covariances, a.timestamp_ns);
    const types::PoseCovariance at_b =
        optimisation::covariance_between(covariances, b.timestamp_ns);
    const double range_m = std::max(a.range_m, b.range_m);
    return max_eigenvalue(at_b.position_m2 - at_a.position_m2) +
           range_m * range_m * max_eigenvalue(at_b.rotation_rad2 - at_a.rotation_rad2);
}

double sigma_of_length_m(const End& a,
                         const End& b,
                         const types::CovarianceTrack& drift,
                         double scale_sigma) {
    const Eigen::Vector3d way = b.p_world - a.p_world;
    const Eigen::Vector3d along = way.stableNormalized();
    return std::sqrt(along.dot((a.scatter_m2 + b.scatter_m2) * along) +
                     drift_variance_m2(a, b, drift) +
                     scale_sigma * scale_sigma * way.squaredNorm());
}

std::vector<dive::Mark> marks_within(const std::vector<dive::Mark>& marks,
                                     const types::TrackingSegment& segment) {
    std::vector<dive::Mark> within;
    for (const dive::Mark& mark : marks)
        if (segment.contains(mark.timestamp_ns)) within.push_back(mark);
    return within;
}

struct MarkedEnds {
    std::vector<dive::Mark> a;
    std::vector<dive::Mark> b;

    std::size_t num_keyframes() const { return std::min(a.size(), b.size()); }
};

// Returns the marks of the segment that shows both ends most often.
MarkedEnds within_one_segment(MarkedEnds marks,
                              const std::vector<types::TrackingSegment>& segments) {
    if (segments.size() < 2) return marks;
    MarkedEnds best;
    for (const types::TrackingSegment& segment : segments) {
        MarkedEnds within{marks_within(marks.a, segment), marks_within(marks.b, segment)};
        if (within.num_keyframes() > best.num_keyframes()) best = std::move(within);
    }
    return best;
}

// Returns the marks of the frames that show both ends, if these are enough: the errors of their
// poses move both alike and cancel in the length.
MarkedEnds in_common_frames(const MarkedEnds& marks) {
    const auto in = [](const std::vector<dive::Mark>& wanted, const std::vector<dive::Mark>& all) {
        std::vector<dive::Mark> common;
        for (const dive::Mark& mark : wanted)
            if (std::any_of(all.begin(), all.end(), [&](const dive::Mark& other) {
                    return other.timestamp_ns == mark.timestamp_ns;
                }))
                common.push_back(mark);
        return common;
    };
    MarkedEnds common{in(marks.a, marks.b), in(marks.b, marks.a)};
    return common.num_keyframes() >= kMinKeyframes ? common : marks;
}

void summarise(KnownDistanceErrors& errors) {
    std::vector<double> differences;
    double products = 0.0;
    double squares = 0.0;
    for (const MeasuredDistance& distance : errors.distances) {
        if (!distance.measured_m) continue;
        differences.push_back(std::abs(*distance.measured_m - distance.known_m));
        products += *distance.measured_m * distance.known_m;
        squares += distance.known_m * distance.known_m;
    }
    errors.num_measured = static_cast<std::int64_t>(differences.size());
    if (differences.empty()) return;
    errors.scale_error = products / squares - 1.0;
    errors.median_abs_error_m = stats::median(differences);
    errors.rmse_m = stats::root_mean_square(differences);
    errors.max_abs_error_m = *std::max_element(differences.begin(), differences.end());
}

}  // namespace

types::Trajectory with_mounting_of(const types::Trajectory& estimate,
                                   const types::Trajectory& ground_truth,
                                   const Eigen::Isometry3d& T_reference_estimate) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (const types::StampedPose& pose : estimate) {
        const auto truth = pose_at(ground_truth, pose.timestamp_ns);
        if (!truth) continue;
        const Eigen::Quaterniond turned(truth->linear().transpose() *
                                        T_reference_estimate.linear() * pose.T_world_imu.linear());
        sum += turned.coeffs() * (turned.coeffs().dot(sum) < 0.0 ? -1.0 : 1.0);
    }
    types::Trajectory result = ground_truth;
    if (sum.norm() == 0.0) return result;
    const Eigen::Quaterniond mean(Eigen::Vector4d(sum.normalized()));
    for (types::StampedPose& pose : result) pose.T_world_imu = pose.T_world_imu * mean;
    return result;
}

std::vector<dive::Mark> mark_point(const Eigen::Vector3d& p_world, const MarkingInput& input) {
    std::vector<dive::Mark> marks;
    if (static_cast<double>(input.reference.distance_m(p_world.cast<float>())) > input.tolerance_m)
        return marks;
    for (const std::int64_t timestamp_ns : input.keyframe_timestamps_ns) {
        const auto T_world_imu = pose_at(input.ground_truth, timestamp_ns);
        if (!T_world_imu) continue;
        const Eigen::Isometry3d T_world_cam0 = *T_world_imu * input.rig.T_imu_cam0;
        const auto cam1 = camera::right_camera_at(input.rig, timestamp_ns);
        const Eigen::Isometry3d T_world_cam1 = *T_world_imu * cam1.T_imu_cam;
        const Eigen::Vector3d p_cam0 = T_world_cam0.inverse() * p_world;
        const auto left = project_inside(input.rig.cam0, p_cam0);
        if (!left || p_cam0.norm() > input.max_range_m ||
            is_hidden(T_world_cam0.translation(), p_world, input))
            continue;
        auto right = project_inside(cam1.camera, T_world_cam1.inverse() * p_world);
        if (is_hidden(T_world_cam1.translation(), p_world, input)) right.reset();
        marks.push_back({timestamp_ns, *left, right});
    }
    return marks;
}

std::optional<Eigen::Vector3d> triangulate(const std::vector<dive::Mark>& marks,
                                           const types::Rig& rig,
                                           const types::Trajectory& trajectory,
                                           int min_keyframes,
                                           double readout_time_s) {
    const std::vector<View> views = views_of(marks, rig, trajectory, min_keyframes, readout_time_s);
    if (views.empty()) return std::nullopt;
    return located(views);
}

KnownDistanceErrors measure_known_distances(const std::vector<dive::KnownDistance>& distances,
                                            const MarkingInput* truth,
                                            const types::Rig& rig,
                                            const KnownPath& path) {
    const types::CovarianceTrack drift =
        with_scale_sigma(path.covariances,
                         offsets_from_start(path.trajectory, path.segments),
                         path.contradiction_sigma,
                         0.0);
    KnownDistanceErrors errors;
    for (const dive::KnownDistance& known : distances) {
        MarkedEnds marks;
        // What the truth marks is where the middle row's pose sees it.
        const double readout_time_s = known.is_marked() ? path.readout_time_s : 0.0;
        if (known.is_marked())
            marks = {known.marks_a, known.marks_b};
        else if (truth)
            marks = {mark_point(known.a_world, *truth), mark_point(known.b_world, *truth)};
        marks = in_common_frames(within_one_segment(std::move(marks), path.segments));
        MeasuredDistance measured;
        measured.name = known.name;
        measured.known_m = known.distance_m;
        measured.num_keyframes_a = static_cast<int>(marks.a.size());
        measured.num_keyframes_b = static_cast<int>(marks.b.size());
        const auto a = end_of(marks.a, rig, path.trajectory, readout_time_s);
        const auto b = end_of(marks.b, rig, path.trajectory, readout_time_s);
        if (a && b) measured.measured_m = (a->p_world - b->p_world).norm();
        if (a && b && !drift.empty())
            measured.sigma_m = sigma_of_length_m(*a, *b, drift, path.scale_sigma);
        errors.distances.push_back(measured);
    }
    summarise(errors);
    return errors;
}

nlohmann::json to_metrics(const KnownDistanceErrors& errors) {
    nlohmann::json list = nlohmann::json::array();
    for (const MeasuredDistance& distance : errors.distances) {
        nlohmann::json entry = {{"name", distance.name},
                                {"known_m", distance.known_m},
                                {"measured_m", nullptr},
                                {"num_keyframes_a", distance.num_keyframes_a},
                                {"num_keyframes_b", distance.num_keyframes_b}};
        if (distance.measured_m) entry["measured_m"] = *distance.measured_m;
        if (distance.sigma_m) {
            const double half_m = stats::kNormal975 * *distance.sigma_m;
            entry["interval95_m"] = {std::max(0.0, *distance.measured_m - half_m),
                                     *distance.measured_m + half_m};
        }
        list.push_back(std::move(entry));
    }
    nlohmann::json json = {{"num_distances", errors.distances.size()},
                           {"num_measured", errors.num_measured},
                           {"distances", list}};
    if (errors.num_measured == 0) return json;
    json["scale_error"] = errors.scale_error;
    json["median_abs_error_m"] = errors.median_abs_error_m;
    json["rmse_m"] = errors.rmse_m;
    json["max_abs_error_m"] = errors.max_abs_error_m;
    return json;
}

}  // namespace divemesh::evaluation
