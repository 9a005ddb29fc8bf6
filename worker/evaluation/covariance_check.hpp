#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "worker/evaluation/trajectory_error.hpp"
#include "worker/types/pose_covariance.hpp"

namespace divemesh::evaluation {

// Compares the stated covariances with the true errors of the position relative to the first pose,
// without alignment.
struct CovarianceCheck {
    std::int64_t num_poses = 0;  // compared
    double mean_nees = 0.0;      // normalised estimation error squared, 3 degrees of freedom
    double share_in_95 = 0.0;    // of the poses whose 95 % ellipsoid contains the truth
};

// Returns nullopt if there are no covariances or the first pose has no ground truth.
std::optional<CovarianceCheck> check_covariances(const types::Trajectory& estimate,
                                                 const types::CovarianceTrack& covariances,
                                                 const types::Trajectory& reference);

nlohmann::json to_metrics(const CovarianceCheck& check);

}  // namespace divemesh::evaluation
