#include "worker/pipeline/outside_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/evaluation/tracking_segments.hpp"
#include "worker/evaluation/trajectory_pairs.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/io/geographic_frame.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::size_t kMaxPoints = 5000;       // of a source; more are thinned evenly
constexpr double kVelocityScaleSigma = 0.005;  // of a DVL: the speed of sound
constexpr double kMaxVelocityGap_s = 1.0;
constexpr double kMedianOfThree = 1.5382;  // of the length of a normal vector in space, sigmas
constexpr double kMaxSigmaFactor = 4.0;

// Returns how far the segment of each keyframe was set apart along x, by the anchors.
std::vector<double> apart_by_segment(const Reconstruction& made) {
    const types::PathPrior& prior = made.optimised.prior;
    std::vector<double> apart_m;
    std::size_t i = 0;
    for (const types::Keyframe& keyframe : made.optimised.keyframes) {
        const auto segment = static_cast<std::size_t>(keyframe.segment);
        if (apart_m.size() <= segment) apart_m.resize(segment + 1, 0.0);
        if (i >= prior.timestamps_ns.size() || prior.timestamps_ns[i] != keyframe.timestamp_ns)
            continue;
        apart_m[segment] = prior.apart_m[i++] * (made.scale ? made.scale->factor() : 1.0);
    }
    return apart_m;
}

types::PathPrior rigid_prior(std::int64_t timestamp_ns) {
    return {.timestamps_ns = {timestamp_ns},
            .apart_m = {0.0},
            .drift = Eigen::MatrixXd::Zero(6, 6),
            .shared = Eigen::MatrixXd::Zero(6, 1)};
}

// Returns the prior of a path that was scaled by `factor`.
types::PathPrior scaled(types::PathPrior prior, double factor) {
    for (Eigen::Index row = 0; row < prior.drift.rows(); row += 6) {
        prior.drift.middleRows<3>(row) *= factor;
        prior.drift.middleCols<3>(row) *= factor;
        prior.shared.middleRows<3>(row) *= factor;
    }
    return prior;
}

// Returns the centre of a marker and its variance along an axis by the images alone.
std::pair<Eigen::Vector3d, double> centre_of(const markers::Marker& marker) {
    Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
    for (Eigen::Index i = 0; i < 4; ++i)
        for (Eigen::Index j = 0; j < 4; ++j)
            covariance_m2 += marker.corner_covariance_m2.block<3, 3>(3 * i, 3 * j) / 16.0;
    return {marker.point(std::nullopt), covariance_m2.trace() / 3.0};
}

// Returns the keyframe of a marker's segment that is nearest to it: the marker moves with it.
const types::Keyframe* nearest_keyframe(const Reconstruction& made, const markers::Marker& marker) {
    const types::Keyframe* nearest = nullptr;
    double least_m = std::numeric_limits<double>::infinity();
    for (const types::Keyframe& keyframe : made.optimised.keyframes) {
        const double distance_m =
            (keyframe.T_world_cam.translation() - marker.point(std::nullopt)).norm();
        if (keyframe.segment != marker.segment || distance_m >= least_m) continue;
        least_m = distance_m;
        nearest = &keyframe;
    }
    return nearest;
}

SourcePoints points_of(const types::PositionSource& source,
                       const PathToJoin& to_join,
                       const Site& site,
                       double later_s) {
    SourcePoints result;
    result.agreement.name = source.name;
    result.agreement.kind = enum_to_text(types::kPositionKindTexts, source.kind);
    result.agreement.epsg = source.epsg;
    result.offset_sigma_m = source.offset_sigma_m;
    const std::size_t stride = 1 + (source.samples.size() - 1) / kMaxPoints;
    for (std::size_t i = 0; i < source.samples.size(); i += stride) {
        const types::PositionSample& sample = source.samples[i];
        const std::int64_t timestamp_ns = sample.timestamp_ns + base::to_ns(later_s);
        ++result.agreement.num_rows;
        const auto T_world_imu = evaluation::pose_at(to_join.trajectory, timestamp_ns);
        if (!T_world_imu) {
            ++result.agreement.num_without_path;
            continue;
        }
        result.points.push_back({timestamp_ns,
                                 *T_world_imu * source.p_imu_instrument,
                                 site.from_utm(sample.utm_m),
                                 sample.sigma_h_m,
                                 sample.sigma_v_m});
    }
    return result;
}

SourcePoints control_points(const Reconstruction& made,
                            const std::vector<double>& apart_m,
                            const Site& site) {
    const types::OutsidePositions& outside = made.dive.outside();
    SourcePoints result;
    result.agreement.name = "control_points";
    result.agreement.kind = "control_points";
    result.agreement.epsg = outside.control_points_epsg;
    for (const types::ControlPoint& known : outside.control_points) {
        ++result.agreement.num_rows;
        bool found = false;
        if (made.markers)
            for (const markers::Marker& marker : made.markers->markers) {
                const types::Keyframe* keyframe =
                    marker.id == known.marker_id ? nearest_keyframe(made, marker) : nullptr;
                if (!keyframe) continue;
                found = true;
                auto [p_world, variance_m2] = centre_of(marker);
                p_world.x() -= apart_m[static_cast<std::size_t>(marker.segment)];
                result.points.push_back(
                    {keyframe->timestamp_ns,
                     p_world,
                     site.from_utm(known.utm_m),
                     std::sqrt(known.sigma_h_m * known.sigma_h_m + variance_m2),
                     known.sigma_v_m > 0.0
                         ? std::sqrt(known.sigma_v_m * known.sigma_v_m + variance_m2)
                         : 0.0});
            }
        if (!found) ++result.agreement.num_without_path;
    }
    return result;
}

// Returns the rotation of the body since `from_ns`, given that to `to_ns`: by the gyroscope, whose
// error is distributed evenly over the time.
Eigen::Quaterniond rotation_since(const imu::InertialPrior& inertial,
                                  std::int64_t from_ns,
                                  std::int64_t to_ns,
                                  std::int64_t timestamp_ns,
                                  const Eigen::Quaterniond& q_from_to) {
    const double share =
        static_cast<double>(timestamp_ns - from_ns) / static_cast<double>(to_ns - from_ns);
    const auto whole = inertial.integral(from_ns, to_ns);
    const auto part = inertial.integral(from_ns, timestamp_ns);
    const Eigen::Quaterniond q_whole = whole ? whole->q_from_to : Eigen::Quaterniond::Identity();
    const Eigen::Quaterniond q_part =
        whole && part ? part->q_from_to : Eigen::Quaterniond::Identity();
    return q_part * base::rotation_from_vector(
                        share * base::vector_from_rotation(q_whole.conjugate() * q_from_to));
}

// Returns the motion of the body from an anchor to the next by the velocities; nullopt where they
// leave a gap.
std::optional<optimisation::OutsideMotion> motion_over(const Reconstruction& made,
                                                       const imu::InertialPrior& inertial,
                                                       const optimisation::AnchoredPath& path,
                                                       std::size_t from) {
    const types::OutsidePositions& outside = made.dive.outside();
    const std::int64_t from_ns = path.timestamp_ns(from);
    const std::int64_t to_ns = path.timestamp_ns(from + 1);
    const Eigen::Quaterniond q_from_to(
        (path.T_world_imu(from).linear().transpose() * path.T_world_imu(from + 1).linear()).eval());
    Eigen::Vector3d moved = Eigen::Vector3d::Zero();  // of the instrument, axes of the body at from
    double variance_m2 = 0.0;
    std::int64_t reached_ns = from_ns;
    const auto& rows = outside.velocities;
    auto row = std::ranges::lower_bound(
        rows, from_ns, {}, [](const types::VelocitySample& v) { return v.timestamp_ns; });
    // Each row holds from the middle between it and the one before to the middle after it.
    for (; row != rows.end() && reached_ns < to_ns; ++row) {
        const std::int64_t until_ns =
            row + 1 == rows.end()
                ? row->timestamp_ns
                : row->timestamp_ns + ((row + 1)->timestamp_ns - row->timestamp_ns) / 2;
        const std::int64_t end_ns = std::min(until_ns, to_ns);
        const double time_s = base::to_s(end_ns - reached_ns);
        if (time_s > kMaxVelocityGap_s) return std::nullopt;
        const Eigen::Quaterniond q_from_now = rotation_since(
            inertial, from_ns, to_ns, reached_ns + (end_ns - reached_ns) / 2, q_from_to);
        moved += time_s * (q_from_now * (outside.T_imu_dvl.linear() * row->velocity_instrument));
        variance_m2 += std::pow(time_s * row->sigma_m_s, 2);
        reached_ns = end_ns;
    }
    if (reached_ns < to_ns) return std::nullopt;
    const Eigen::Vector3d arm = outside.T_imu_dvl.translation();
    const Eigen::Vector3d motion_imu = moved - (q_from_to * arm - arm);
    return optimisation::OutsideMotion{
        from,
        motion_imu,
        std::sqrt(variance_m2 + std::pow(kVelocityScaleSigma * motion_imu.norm(), 2))};
}

}  // namespace

Eigen::Vector3d Site::from_utm(const Eigen::Vector3d& utm_m) const {
    Eigen::Vector3d p_site;
    p_site << A.leftCols<2>().inverse() * (utm_m.head<2>() - A.col(2)), utm_m.z();
    return p_site;
}

Eigen::Vector3d Site::to_utm(const Eigen::Vector3d& p_site) const {
    Eigen::Vector3d utm_m;
    utm_m << A.leftCols<2>() * p_site.head<2>() + A.col(2), p_site.z();
    return utm_m;
}

Site site_of(const types::OutsidePositions& outside) {
    const Eigen::Vector3d& first_m = outside.sources.empty()
                                         ? outside.control_points.front().utm_m
                                         : outside.sources.front().samples.front().utm_m;
    Site site;
    site.utm_epsg = outside.utm_epsg;
    site.origin = io::geographic_position(first_m.head<2>(), outside.utm_epsg);
    site.A = io::utm_frame(site.origin, outside.utm_epsg).A;
    return site;
}

PathToJoin path_to_join(const Reconstruction& made) {
    const types::OptimisedTrack& optimised = made.optimised;
    const std::vector<double> apart_m = apart_by_segment(made);
    const auto back = [&](Eigen::Isometry3d T_world_body, std::size_t segment) {
        T_world_body.translation().x() -= apart_m[segment];
        return T_world_body;
    };
    types::Trajectory trajectory = optimised.trajectory;
    const auto segments =
        evaluation::segment_numbers(trajectory, optimised.keyframes, optimised.breaks_ns);
    for (std::size_t i = 0; i < trajectory.size(); ++i)
        trajectory[i].T_world_imu = back(trajectory[i].T_world_imu, segments[i]);
    types::PathPrior prior = optimised.prior.empty()
                                 ? rigid_prior(optimised.keyframes.front().timestamp_ns)
                                 : scaled(optimised.prior, made.scale ? made.scale->factor() : 1.0);
    std::vector<Eigen::Isometry3d> anchors;
    std::size_t k = 0;
    for (const std::int64_t timestamp_ns : prior.timestamps_ns) {
        while (optimised.keyframes[k].timestamp_ns != timestamp_ns) ++k;
        const types::Keyframe& keyframe = optimised.keyframes[k];
        anchors.push_back(back(keyframe.T_world_cam * optimised.rig.T_imu_cam.inverse(),
                               static_cast<std::size_t>(keyframe.segment)));
    }
    const types::Breaks breaks_ns = optimised.prior.empty() ? types::Breaks() : optimised.breaks_ns;
    return {prior,
            optimisation::AnchoredPath(prior.timestamps_ns, std::move(anchors), breaks_ns),
            std::move(trajectory)};
}

std::vector<SourcePoints> source_points(const Reconstruction& made,
                                        const PathToJoin& to_join,
                                        const Site& site,
                                        double later_s) {
    std::vector<SourcePoints> sources;
    for (const types::PositionSource& source : made.dive.outside().sources)
        sources.push_back(points_of(source, to_join, site, later_s));
    if (!made.dive.outside().control_points.empty())
        sources.push_back(control_points(made, apart_by_segment(made), site));
    return sources;
}

std::optional<VelocityMotions> motions_by_velocity(const Reconstruction& made,
                                                   const PathToJoin& to_join) {
    const auto& rows = made.dive.outside().velocities;
    if (rows.empty()) return std::nullopt;
    const imu::InertialPrior inertial(made.recording, made.options(), made.track.left_out);
    VelocityMotions result;
    types::SourceAgreement& agreement = result.agreement;
    agreement.name = "velocity0";
    agreement.kind = "dvl";
    agreement.num_rows = std::ssize(rows);
    std::vector<double> in_sight_sigmas;
    std::int64_t num_used = 0;
    double squares_m2 = 0.0;
    for (std::size_t i = 1; i < to_join.path.size(); ++i) {
        const auto motion = motion_over(made, inertial, to_join.path, i - 1);
        if (!motion) continue;
        if (to_join.path.first_of_run(i) == i) {
            result.motions.push_back(*motion);
            num_used += std::ranges::count_if(rows, [&](const types::VelocitySample& row) {
                return row.timestamp_ns >= to_join.path.timestamp_ns(i - 1) &&
                       row.timestamp_ns < to_join.path.timestamp_ns(i);
            });
            continue;
        }
        const Eigen::Vector3d seen = to_join.path.T_world_imu(i - 1).linear().transpose() *
                                     (to_join.path.T_world_imu(i).translation() -
                                      to_join.path.T_world_imu(i - 1).translation());
        const double off_m = (motion->motion_imu - seen).norm();
        in_sight_sigmas.push_back(off_m / motion->sigma_m);
        squares_m2 += off_m * off_m;
    }
    if (!in_sight_sigmas.empty()) {
        agreement.rms_m = std::sqrt(squares_m2 / static_cast<double>(in_sight_sigmas.size()));
        agreement.sigma_factor =
            std::max(1.0, stats::upper_median(std::move(in_sight_sigmas)) / kMedianOfThree);
    }
    agreement.num_without_path = agreement.num_rows - num_used;
    if (agreement.sigma_factor > kMaxSigmaFactor) {
        agreement.left_out = "the motions of keyframes in sight differ from them by " +
                             base::fixed(agreement.rms_m, 2) + " m (RMS), " +
                             base::fixed(agreement.sigma_factor, 0) +
                             " times their sigma: their unit, clock or axes (T_BS) are wrong";
        result.motions.clear();
    }
    for (optimisation::OutsideMotion& motion : result.motions)
        motion.sigma_m *= agreement.sigma_factor;
    return result;
}

}  // namespace divemesh::pipeline
