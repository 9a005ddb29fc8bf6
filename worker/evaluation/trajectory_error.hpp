#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "worker/evaluation/revisit_error.hpp"
#include "worker/evaluation/trajectory_error_options.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// Relative error over all parts of the path with a true length of length_m (Geiger et al. 2012,
// KITTI odometry, with lengths that suit a dive and every frame as a start).
struct SegmentError {
    double length_m = 0.0;
    std::int64_t num_segments = 0;
    double translation_mean_percent = 0.0;
    double translation_rmse_percent = 0.0;
    double rotation_mean_deg_per_m = 0.0;
    double rotation_rmse_deg_per_m = 0.0;
};

// The error of an estimated path. Absolute errors are after the best SE(3) alignment of positions
// (Umeyama 1991, scale fixed at 1), relative ones without alignment.
struct TrajectoryError {
    std::int64_t num_poses = 0;          // compared
    std::int64_t num_poses_outside = 0;  // of the estimate, without ground truth
    double path_length_m = 0.0;          // of the truth at the compared timestamps
    double ate_rmse_m = 0.0;
    double ate_mean_m = 0.0;
    double ate_median_m = 0.0;
    double ate_max_m = 0.0;
    double rotation_rmse_deg = 0.0;  // after the same alignment
    double sim3_scale = 1.0;         // diagnostic: the best-fitting scale, not applied
    double sim3_ate_rmse_m = 0.0;
    double end_drift_m = 0.0;                 // at the last pose, with the first poses aligned
    std::optional<double> end_drift_percent;  // of path_length_m; nullopt: that is 0
    // Mean of translation error / length over all segments; nullopt: the path has none.
    std::optional<double> drift_percent;
    std::vector<SegmentError> segments;   // 1, 2, 5, 10 m, as far as the path is long enough
    std::optional<RevisitError> revisit;  // nullopt: the path revisits no place
    Eigen::Isometry3d T_reference_estimate = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d T_reference_surface = Eigen::Isometry3d::Identity();  // of align_poses()
    std::vector<std::int64_t> timestamps_ns;                                // of the compared poses
    std::vector<Eigen::Vector3d> reference;  // true positions of these poses
    std::vector<Eigen::Vector3d> aligned;    // estimated positions in the reference frame
};

// Interpolates the truth to the estimate's timestamps, positions linearly, orientations by slerp. A
// path that is almost a straight line does not determine its own roll; then the orientations take
// part in the alignment. Throws Error{BadData} if fewer than three poses can be paired.
TrajectoryError trajectory_error(const types::Trajectory& estimate,
                                 const types::Trajectory& reference,
                                 const TrajectoryErrorOptions& options = {});

nlohmann::json to_metrics(const TrajectoryError& error);

}  // namespace divemesh::evaluation
