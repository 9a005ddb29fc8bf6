#include "worker/pipeline/join_positions.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "worker/base/angle.hpp"
#include "worker/base/text.hpp"
#include "worker/evaluation/tracking_segments.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/io/geographic_frame.hpp"
#include "worker/optimisation/covariance_between.hpp"
#include "worker/optimisation/expected_path_error.hpp"
#include "worker/pipeline/join_sources.hpp"
#include "worker/pipeline/outside_points.hpp"
#include "worker/pipeline/stage_functions.hpp"
#include "worker/pipeline/vertical.hpp"

namespace divemesh::pipeline {
namespace {

constexpr double kTiltSigma_rad = 0.005;  // of a vertical that sensors measured
constexpr double kUnknownTilt_rad = 0.5;
constexpr double kFreeScale = 0.1;  // sigma of a scale that the cameras do not tell
constexpr double kMaxPriorFactor = 6.0;
// Segments whose place relative to the first is known as well are put into its world.
constexpr double kMaxJoined_m = 0.3;
constexpr double kMaxJoined_rad = 0.05;
constexpr double kMaxHeading_deg = 10.0;   // one standard deviation of a heading that is stated
constexpr std::int64_t kMinPositions = 8;  // of one source, that show whether they fit the path
constexpr std::int64_t kMinControlPoints = 3;
constexpr const char* kRemedy =
    "check the coordinate system, the clock and the place of the instrument (T_BS) of that source";

// Returns how well the vertical is known at the first pose. The world was levelled by all of its
// poses, so the error of their rotations relative to the first is part of it.
double tilt_sigma(const Reconstruction& made) {
    double variance = kTiltSigma_rad * kTiltSigma_rad;
    const types::PathPrior& prior = made.optimised.prior;
    const auto num_anchors = static_cast<double>(prior.timestamps_ns.size());
    for (Eigen::Index row = 3; row < prior.drift.rows(); row += 6)
        for (Eigen::Index axis = row; axis < row + 2; ++axis)
            variance += 0.5 * (prior.drift(axis, axis) + prior.shared.row(axis).squaredNorm()) /
                        num_anchors;
    imu::InertialPrior inertial(made.recording, made.options(), made.track.left_out);
    inertial.set_pressure_error(made.track.pressure_error_m);
    return vertical_is_known(inertial, made.optimised) ? std::sqrt(variance) : kUnknownTilt_rad;
}

// Returns the sources as functions of the time by which their clocks are shifted.
PointsAt points_of(const Reconstruction& made, const PathToJoin& to_join) {
    const types::OutsidePositions& outside = made.dive.outside();
    if (outside.sources.empty() && outside.control_points.empty())
        return [](double) { return std::vector<SourcePoints>(); };
    return [&made, &to_join, site = site_of(outside)](double later_s) {
        return source_points(made, to_join, site, later_s);
    };
}

std::string file_of(const types::SourceAgreement& source) {
    return source.kind == "control_points" ? "control_points.json"
                                           : "mav0/" + source.name + "/data.csv";
}

std::vector<Finding> findings_on(const std::vector<types::SourceAgreement>& sources) {
    std::vector<Finding> findings;
    for (const types::SourceAgreement& source : sources) {
        if (source.left_out.empty()) continue;
        findings.push_back({Severity::Warning,
                            "positions_left_out",
                            file_of(source),
                            source.name + " (" + source.kind +
                                ") contradicts the images and was left out: " + source.left_out,
                            kRemedy});
    }
    return findings;
}

// Returns the covariance of a rotation or position of an anchor relative to another one.
Eigen::Matrix<double, 6, 6> between(const Eigen::MatrixXd& covariance,
                                    std::size_t a,
                                    std::size_t b) {
    const auto i = 6 * static_cast<Eigen::Index>(a);
    const auto j = 6 * static_cast<Eigen::Index>(b);
    return covariance.block<6, 6>(i, i) + covariance.block<6, 6>(j, j) -
           covariance.block<6, 6>(i, j) - covariance.block<6, 6>(j, i);
}

double largest_sigma(const Eigen::Matrix3d& covariance) {
    return std::sqrt(
        std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues()[2]));
}

// Returns the covariances of the anchors in the axes of the first pose.
types::CovarianceTrack track_of(const optimisation::AnchoredPath& path,
                                const Eigen::MatrixXd& covariance,
                                const Eigen::Matrix3d& R_world_first) {
    types::CovarianceTrack track;
    for (std::size_t i = 0; i < path.size(); ++i) {
        const auto at = 6 * static_cast<Eigen::Index>(i);
        track.push_back(
            {path.timestamp_ns(i),
             R_world_first.transpose() * covariance.block<3, 3>(at, at) * R_world_first,
             R_world_first.transpose() * covariance.block<3, 3>(at + 3, at + 3) * R_world_first});
    }
    return track;
}

Eigen::Matrix3d without_negative(const Eigen::Matrix3d& covariance) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
        0.5 * (covariance + covariance.transpose()));
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
           eigen.eigenvectors().transpose();
}

// Moves the result as the joined path says.
class Mover {
public:
    Mover(const PathToJoin& to_join, const optimisation::JoinedPath& joined, Reconstruction& made)
        : to_join_(to_join), joined_(joined), made_(made), optimised_(made.optimised) {}

    void run() {
        choose_segments();
        move_poses();
        replace_covariances();
        replace_path_uncertainty();
    }

private:
    void choose_segments();
    void move_poses();
    Eigen::Isometry3d moved(std::int64_t timestamp_ns,
                            const Eigen::Isometry3d& T_world_body,
                            std::int32_t segment) const;
    void replace_covariances();
    void replace_path_uncertainty();

    const PathToJoin& to_join_;
    const optimisation::JoinedPath& joined_;
    Reconstruction& made_;
    types::OptimisedTrack& optimised_;
    std::map<std::int32_t, double> apart_m_;  // of each segment
    std::set<std::int32_t> placed_;           // segments in the world of the first
};

// Finds the segments that are put into the world of the first.
void Mover::choose_segments() {
    std::size_t i = 0;
    const double factor = made_.scale ? made_.scale->factor() : 1.0;
    types::GeoReference& georeference = *made_.georeference;
    for (const types::Keyframe& keyframe : optimised_.keyframes) {
        if (i >= to_join_.path.size() || to_join_.path.timestamp_ns(i) != keyframe.timestamp_ns)
            continue;
        if (!apart_m_.contains(keyframe.segment)) {
            apart_m_[keyframe.segment] = factor * to_join_.prior.apart_m[i];
            const Eigen::Matrix<double, 6, 6> relative = between(joined_.covariance, 0, i);
            const double sigma_m = largest_sigma(relative.topLeftCorner<3, 3>());
            if (sigma_m <= kMaxJoined_m &&
                largest_sigma(relative.bottomRightCorner<3, 3>()) <= kMaxJoined_rad) {
                placed_.insert(keyframe.segment);
                georeference.joined_sigma_m = std::max(georeference.joined_sigma_m, sigma_m);
            }
        }
        ++i;
    }
    georeference.num_joined_segments = static_cast<int>(placed_.size()) - 1;
}

Eigen::Isometry3d Mover::moved(std::int64_t timestamp_ns,
                               const Eigen::Isometry3d& T_world_body,
                               std::int32_t segment) const {
    if (!placed_.contains(segment)) return T_world_body;
    Eigen::Isometry3d T_estimated = T_world_body;
    T_estimated.translation().x() -= apart_m_.at(segment);
    return optimisation::corrected(to_join_.path, joined_.T_new_old, timestamp_ns, T_estimated);
}

void Mover::move_poses() {
    const auto segments = evaluation::segment_numbers(
        optimised_.trajectory, optimised_.keyframes, optimised_.breaks_ns);
    const auto of_predicted = evaluation::segment_numbers(
        optimised_.predicted, optimised_.keyframes, optimised_.breaks_ns);
    double& largest_m = made_.georeference->largest_correction_m;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        types::StampedPose& pose = optimised_.trajectory[i];
        const auto segment = static_cast<std::int32_t>(segments[i]);
        const Eigen::Isometry3d T_moved = moved(pose.timestamp_ns, pose.T_world_imu, segment);
        if (apart_m_[segment] == 0.0)
            largest_m = std::max(largest_m,
                                 (T_moved.translation() - pose.T_world_imu.translation()).norm());
        pose.T_world_imu = T_moved;
    }
    for (std::size_t i = 0; i < of_predicted.size(); ++i) {
        types::StampedPose& pose = optimised_.predicted[i];
        pose.T_world_imu =
            moved(pose.timestamp_ns, pose.T_world_imu, static_cast<std::int32_t>(of_predicted[i]));
    }
    const Eigen::Isometry3d& T_imu_cam = optimised_.rig.T_imu_cam;
    bool all_placed = true;
    for (auto* frames : {&optimised_.keyframes, &optimised_.mapped})
        for (types::Keyframe& frame : *frames) {
            frame.T_world_cam =
                moved(frame.timestamp_ns, frame.T_world_cam * T_imu_cam.inverse(), frame.segment) *
                T_imu_cam;
            if (placed_.contains(frame.segment))
                frame.segment = 0;
            else
                all_placed = false;
        }
    if (all_placed) optimised_.max_depth_m = 0.0;
}

void Mover::replace_covariances() {
    if (optimised_.covariances.empty() || optimised_.prior.empty()) return;
    const Eigen::Matrix3d R =
        joined_.T_new_old.front().linear() * to_join_.path.T_world_imu(0).linear();
    const auto before = track_of(to_join_.path, joined_.prior_covariance, R);
    const auto after = track_of(to_join_.path, joined_.covariance, R);
    for (types::PoseCovariance& pose : optimised_.covariances) {
        const auto old = optimisation::covariance_between(before, pose.timestamp_ns);
        const auto now = optimisation::covariance_between(after, pose.timestamp_ns);
        pose.position_m2 = without_negative(pose.position_m2 - old.position_m2) + now.position_m2;
        pose.rotation_rad2 =
            without_negative(pose.rotation_rad2 - old.rotation_rad2) + now.rotation_rad2;
    }
}

void Mover::replace_path_uncertainty() {
    types::PathUncertainty& path = optimised_.statistics.path;
    if (!path.is_known() || optimised_.prior.empty()) return;
    std::vector<Eigen::Vector3d> positions;
    const auto num = static_cast<Eigen::Index>(to_join_.path.size());
    Eigen::MatrixXd before(3 * num, 3 * num);
    Eigen::MatrixXd after(3 * num, 3 * num);
    for (Eigen::Index i = 0; i < num; ++i) {
        const auto anchor = static_cast<std::size_t>(i);
        positions.push_back(joined_.T_new_old[anchor] *
                            to_join_.path.T_world_imu(anchor).translation());
        for (Eigen::Index j = 0; j < num; ++j) {
            before.block<3, 3>(3 * i, 3 * j) = joined_.prior_covariance.block<3, 3>(6 * i, 6 * j);
            after.block<3, 3>(3 * i, 3 * j) = joined_.covariance.block<3, 3>(6 * i, 6 * j);
        }
    }
    const types::PathUncertainty old = optimisation::after_alignment(positions, before);
    const types::PathUncertainty now = optimisation::after_alignment(positions, after);
    path.mean_square_m2 =
        std::max(0.0, path.mean_square_m2 - old.mean_square_m2) + now.mean_square_m2;
    path.degrees_of_freedom = now.degrees_of_freedom;
    path.scale_sigma = optimisation::scale_sigma(positions, after);
    path.shared_scale_sigma = std::min(path.shared_scale_sigma, path.scale_sigma);
    path.vertical_scale_sigma =
        std::min(path.vertical_scale_sigma, optimisation::vertical_scale_sigma(positions, after));
    path.spread_m2 = optimisation::spread_m2(positions);
}

// Sets where the world's origin lies on the earth.
void place(const Site& site,
           const optimisation::JoinedPath& joined,
           types::GeoReference& georeference) {
    const Eigen::Vector3d origin_site = joined.T_site_world.translation();
    georeference.utm_epsg = site.utm_epsg;
    georeference.utm_m = site.to_utm(origin_site);
    types::GeographicPosition position =
        io::geographic_position(georeference.utm_m.head<2>(), site.utm_epsg);
    const Eigen::Vector3d x_site = joined.T_site_world.linear().col(0);
    const double azimuth_deg = 90.0 - base::kDegPerRad * std::atan2(x_site.y(), x_site.x());
    georeference.heading_sigma_deg =
        base::kDegPerRad * std::sqrt(std::max(0.0, joined.site_covariance(2, 2)));
    if (georeference.heading_sigma_deg <= kMaxHeading_deg)
        position.x_azimuth_deg = azimuth_deg < 0.0 ? azimuth_deg + 360.0 : azimuth_deg;
    georeference.position = position;
    georeference.sigma_m =
        joined.site_covariance.bottomRightCorner<3, 3>().diagonal().cwiseMax(0.0).cwiseSqrt();
    constexpr double kMaxHeight_m = 100.0;  // one standard deviation: nothing measured it
    georeference.has_height = georeference.sigma_m.z() < kMaxHeight_m;
    if (!georeference.has_height) georeference.utm_m.z() = 0.0;
}

bool is_one_segment(const std::vector<types::Keyframe>& keyframes) {
    return std::ranges::all_of(
        keyframes, [](const types::Keyframe& keyframe) { return keyframe.segment == 0; });
}

// Returns why segments cannot be joined whose errors are not known together.
Finding not_adjusted() {
    return {Severity::Warning,
            "positions_left_out",
            "",
            "the dive is in several segments, and its path was not adjusted as a whole: positions "
            "cannot place it",
            "use the preset standard or accurate"};
}

Finding not_converged() {
    return {
        Severity::Warning,
        "positions_not_joined",
        "",
        "joining the path with positions or velocities did not converge, or they cover no place "
        "of the path that they could correct: the result is as without them",
        "record positions over the whole dive, and check their sigmas"};
}

Finding contradicting(double prior_factor) {
    return {Severity::Warning,
            "positions_contradict_path",
            "",
            "the positions bend the path by " + base::fixed(prior_factor, 1) +
                " times as much as the images allow: they place the whole result, but the path is "
                "as the cameras measured it",
            "check the calibration of the cameras, and the sigma of the positions"};
}

// Returns a warning if the place is known by so few positions that they could not be tested.
std::optional<Finding> untested_finding(const types::GeoReference& georeference) {
    std::int64_t num_used = 0;
    for (const types::SourceAgreement& source : georeference.sources) {
        if (source.kind == "control_points" && source.num_used() >= kMinControlPoints)
            return std::nullopt;
        num_used = std::max(num_used, source.kind == "dvl" ? 0 : source.num_used());
    }
    if (num_used == 0 || num_used >= kMinPositions) return std::nullopt;
    return Finding{Severity::Warning,
                   "positions_untested",
                   "",
                   "only " + std::to_string(num_used) +
                       " positions place the result: a wrong clock or coordinate system would not "
                       "show, and place and heading may be wrong by more than their sigmas",
                   "record positions over the whole dive, or survey three markers"};
}

// Returns what the positions did.
Finding joined_finding(const types::GeoReference& georeference) {
    std::string used;
    for (const types::SourceAgreement& source : georeference.sources)
        if (source.num_used() > 0)
            used += (used.empty() ? "" : ", ") + std::to_string(source.num_used()) + " of " +
                    std::to_string(source.num_rows) + " rows of " + source.name;
    std::string text = "the path was joined with " + (used.empty() ? "velocities" : used);
    if (georeference.position)
        text += "; its start is known to " +
                base::fixed(georeference.sigma_m.head<2>().maxCoeff(), 2) +
                " m and its heading to " + base::fixed(georeference.heading_sigma_deg, 2) +
                " degrees (one sigma)";
    if (georeference.num_joined_segments > 0)
        text += "; " + std::to_string(georeference.num_joined_segments) +
                " further segments were put into the world of the first, to " +
                base::fixed(georeference.joined_sigma_m, 2) +
                " m: surface that both saw may be there twice";
    return {Severity::Info, "positions_used", "", text, ""};
}

}  // namespace

std::optional<evaluation::ScaleCheck> scale_by_positions(const Reconstruction& made) {
    const types::OutsidePositions& outside = made.dive.outside();
    if (made.has_failed() || made.optimised.prior.empty() ||
        (outside.sources.empty() && outside.control_points.empty()))
        return std::nullopt;
    const PathToJoin to_join = path_to_join(made);
    const JoinedSources found = join_sources(to_join,
                                             points_of(made, to_join),
                                             {},
                                             {.tilt_sigma_rad = tilt_sigma(made),
                                              .scale_sigma = kFreeScale,
                                              .calibration_is_exact = true});
    if (!found.joined.converged) return std::nullopt;
    return evaluation::ScaleCheck{1.0 + found.joined.scale_error, found.joined.scale_error_sigma};
}

void join_positions(Reconstruction& made) {
    if (made.has_failed() || made.dive.outside().empty() || made.optimised.keyframes.empty())
        return;
    if (made.optimised.prior.empty() && !is_one_segment(made.optimised.keyframes)) {
        made.optimised.findings.push_back(not_adjusted());
        return;
    }
    PathToJoin to_join = path_to_join(made);
    optimisation::JoinSettings settings{
        .tilt_sigma_rad = tilt_sigma(made),
        .scale_sigma = made.optimised.statistics.path.shared_scale_sigma};
    const auto velocities = motions_by_velocity(made, to_join);
    JoinedSources found =
        join_sources(to_join,
                     points_of(made, to_join),
                     velocities ? velocities->motions : std::vector<optimisation::OutsideMotion>(),
                     settings);
    types::GeoReference& georeference = made.georeference.emplace();
    std::vector<Finding>& findings = made.optimised.findings;
    const bool bends = found.joined.converged && found.prior_factor > kMaxPriorFactor;
    if (bends) {
        findings.push_back(contradicting(found.prior_factor));
        if (!is_one_segment(made.optimised.keyframes)) return;  // no rigid body
        made.optimised.prior = {};
        to_join = path_to_join(made);
        found = join_sources(to_join, points_of(made, to_join), {}, settings);
    }
    georeference.sources = found.sources;
    if (velocities) georeference.sources.push_back(velocities->agreement);
    const std::vector<Finding> left_out = findings_on(georeference.sources);
    findings.insert(findings.end(), left_out.begin(), left_out.end());
    if (!found.joined.converged) {
        if (left_out.size() < georeference.sources.size()) findings.push_back(not_converged());
        return;
    }
    const bool has_points =
        std::ranges::any_of(found.sources, [](const auto& s) { return s.num_used() > 0; });
    if (has_points) place(site_of(made.dive.outside()), found.joined, georeference);
    georeference.path_joined = to_join.path.size() > 1;
    georeference.path_sigma_factor = found.prior_factor;
    if (georeference.path_joined) Mover(to_join, found.joined, made).run();
    findings.push_back(joined_finding(georeference));
    if (const auto untested = untested_finding(georeference)) findings.push_back(*untested);
    write_trajectories(made);
}

}  // namespace divemesh::pipeline
