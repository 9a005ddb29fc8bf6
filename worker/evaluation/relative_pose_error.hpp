#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "worker/evaluation/trajectory_pairs.hpp"

namespace divemesh::evaluation {

// The length of the compared motions and how they are chosen.
struct RelativePoseOptions {
    enum class Pairs {
        Consecutive,  // each pair begins where the one before ended
        All  // each pose with the one nearest to delta_m ahead of it, within a tenth of delta_m
    };
    double delta_m = 10.0;  // along the estimated path
    Pairs pairs = Pairs::Consecutive;
};

// RPE as defined by the tool evo (M. Grupp, "evo: Python package for the evaluation of odometry and
// SLAM", metrics.RPE with delta in metres): the error of the estimated motion between two poses
// that are delta_m apart along the estimate, without alignment.
struct RelativePoseError {
    double delta_m = 0.0;
    std::int64_t num_pairs = 0;
    double translation_rmse_m = 0.0;
    double translation_mean_m = 0.0;
    double translation_median_m = 0.0;
    double translation_max_m = 0.0;
    double rotation_rmse_deg = 0.0;
};

// Returns num_pairs 0, without an exception, if the path is shorter than two deltas.
RelativePoseError relative_pose_error(const std::vector<PosePair>& poses,
                                      const RelativePoseOptions& options);

nlohmann::json to_metrics(const RelativePoseError& error);

}  // namespace divemesh::evaluation
