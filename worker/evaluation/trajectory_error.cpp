#include "worker/evaluation/trajectory_error.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "schemas/error.hpp"
#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/evaluation/alignment.hpp"
#include "worker/evaluation/trajectory_pairs.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/summary.hpp"

namespace divemesh::evaluation {
namespace {

constexpr double kSegmentLengths_m[] = {1.0, 2.0, 5.0, 10.0};

double angle_deg(const Eigen::Matrix3d& R) { return base::angle_rad(R) * base::kDegPerRad; }

// Returns the path length up to each pair.
std::vector<double> path_lengths(const std::vector<PosePair>& pairs) {
    std::vector<double> lengths(pairs.size(), 0.0);
    for (std::size_t i = 1; i < pairs.size(); ++i)
        lengths[i] = lengths[i - 1] + (pairs[i].T_reference_body.translation() -
                                       pairs[i - 1].T_reference_body.translation())
                                          .norm();
    return lengths;
}

// Returns the error of the estimated motion between two moments.
Eigen::Isometry3d relative_error(const PosePair& from, const PosePair& to) {
    const Eigen::Isometry3d truth = from.T_reference_body.inverse() * to.T_reference_body;
    const Eigen::Isometry3d estimate = from.T_world_body.inverse() * to.T_world_body;
    return truth.inverse() * estimate;
}

SegmentError segment_error(const std::vector<PosePair>& pairs,
                           const std::vector<double>& lengths,
                           double length_m) {
    std::vector<double> translation_percent;
    std::vector<double> rotation_deg_per_m;
    for (std::size_t start = 0; start < pairs.size(); ++start) {
        const auto end = std::lower_bound(lengths.begin() + static_cast<std::ptrdiff_t>(start),
                                          lengths.end(),
                                          lengths[start] + length_m);
        if (end == lengths.end()) break;
        const double length = *end - lengths[start];
        const auto stop = static_cast<std::size_t>(end - lengths.begin());
        const Eigen::Isometry3d error = relative_error(pairs[start], pairs[stop]);
        translation_percent.push_back(error.translation().norm() / length * 100.0);
        rotation_deg_per_m.push_back(angle_deg(error.linear()) / length);
    }
    return {length_m,
            static_cast<std::int64_t>(translation_percent.size()),
            stats::mean(translation_percent),
            stats::root_mean_square(translation_percent),
            stats::mean(rotation_deg_per_m),
            stats::root_mean_square(rotation_deg_per_m)};
}

void add_relative_errors(const std::vector<PosePair>& pairs, TrajectoryError& result) {
    const std::vector<double> lengths = path_lengths(pairs);
    result.path_length_m = lengths.back();
    double weighted_percent = 0.0;
    double num_segments = 0.0;
    for (const double length_m : kSegmentLengths_m) {
        const SegmentError segment = segment_error(pairs, lengths, length_m);
        if (segment.num_segments == 0) continue;
        const auto count = static_cast<double>(segment.num_segments);
        weighted_percent += count * segment.translation_mean_percent;
        num_segments += count;
        result.segments.push_back(segment);
    }
    if (num_segments > 0.0) result.drift_percent = weighted_percent / num_segments;
    result.end_drift_m = relative_error(pairs.front(), pairs.back()).translation().norm();
    if (result.path_length_m > 0.0)
        result.end_drift_percent = result.end_drift_m / result.path_length_m * 100.0;
}

void add_absolute_errors(const std::vector<PosePair>& pairs, TrajectoryError& result) {
    const Alignment alignment = align(pairs);
    const std::vector<Eigen::Vector3d> scaled = scaled_about_centre(pairs, alignment);
    std::vector<double> errors;
    std::vector<double> scaled_errors;
    std::vector<double> angles_deg;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const PosePair& pair = pairs[i];
        const Eigen::Isometry3d aligned = alignment.T_reference_world * pair.T_world_body;
        const Eigen::Vector3d truth = pair.T_reference_body.translation();
        errors.push_back((aligned.translation() - truth).norm());
        scaled_errors.push_back((scaled[i] - truth).norm());
        angles_deg.push_back(
            angle_deg(pair.T_reference_body.linear().transpose() * aligned.linear()));
        result.timestamps_ns.push_back(pair.timestamp_ns);
        result.reference.push_back(truth);
        result.aligned.push_back(aligned.translation());
    }
    result.T_reference_estimate = alignment.T_reference_world;
    result.T_reference_surface = align_poses(pairs);
    result.sim3_scale = alignment.sim3_scale;
    result.sim3_ate_rmse_m = stats::root_mean_square(scaled_errors);
    result.ate_rmse_m = stats::root_mean_square(errors);
    result.ate_mean_m = stats::mean(errors);
    result.ate_max_m = *std::max_element(errors.begin(), errors.end());
    result.ate_median_m = stats::median(errors);
    result.rotation_rmse_deg = stats::root_mean_square(angles_deg);
}

nlohmann::json number_or_null(const std::optional<double>& value) {
    return value ? nlohmann::json(*value) : nlohmann::json();
}

}  // namespace

TrajectoryError trajectory_error(const types::Trajectory& estimate,
                                 const types::Trajectory& reference,
                                 const TrajectoryErrorOptions& options) {
    if (options.pair_by_index && estimate.size() != reference.size())
        throw Error(ErrorCode::BadData,
                    "the trajectories have " + std::to_string(estimate.size()) + " and " +
                        std::to_string(reference.size()) +
                        " lines, but are paired line by line: give both the same frames");
    const std::vector<PosePair> pairs = pair_poses(estimate, reference, options);
    if (pairs.size() < 3)
        throw Error(ErrorCode::BadData,
                    "only " + std::to_string(pairs.size()) + " of " +
                        std::to_string(estimate.size()) +
                        " poses have ground truth at their time: check that both trajectories use "
                        "the same clock and the same unit of time");
    TrajectoryError result;
    result.num_poses = static_cast<std::int64_t>(pairs.size());
    result.num_poses_outside = static_cast<std::int64_t>(estimate.size() - pairs.size());
    add_absolute_errors(pairs, result);
    add_relative_errors(pairs, result);
    result.revisit = revisit_error(pairs);
    return result;
}

nlohmann::json to_metrics(const TrajectoryError& error) {
    nlohmann::json segments = nlohmann::json::array();
    for (const SegmentError& segment : error.segments)
        segments.push_back({{"length_m", segment.length_m},
                            {"num_segments", segment.num_segments},
                            {"translation_mean_percent", segment.translation_mean_percent},
                            {"translation_rmse_percent", segment.translation_rmse_percent},
                            {"rotation_mean_deg_per_m", segment.rotation_mean_deg_per_m},
                            {"rotation_rmse_deg_per_m", segment.rotation_rmse_deg_per_m}});
    nlohmann::json metrics = {{"num_poses", error.num_poses},
                              {"num_poses_outside", error.num_poses_outside},
                              {"path_length_m", error.path_length_m},
                              {"ate_rmse_m", error.ate_rmse_m},
                              {"ate_mean_m", error.ate_mean_m},
                              {"ate_median_m", error.ate_median_m},
                              {"ate_max_m", error.ate_max_m},
                              {"rotation_rmse_deg", error.rotation_rmse_deg},
                              {"sim3_scale", error.sim3_scale},
                              {"sim3_ate_rmse_m", error.sim3_ate_rmse_m},
                              {"end_drift_m", error.end_drift_m},
                              {"end_drift_percent", number_or_null(error.end_drift_percent)},
                              {"drift_percent", number_or_null(error.drift_percent)},
                              {"segments", segments}};
    if (error.revisit)
        metrics["revisit"] = {{"num_frames", error.revisit->num_frames},
                              {"translation_rmse_m", error.revisit->translation_rmse_m},
                              {"translation_max_m", error.revisit->translation_max_m},
                              {"rotation_rmse_deg", error.revisit->rotation_rmse_deg}};
    return metrics;
}

}  // namespace divemesh::evaluation
