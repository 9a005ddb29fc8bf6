#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/evaluation/trajectory_error_options.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// An estimated pose and the true pose of the same moment, both of the reference's body.
struct PosePair {
    std::int64_t timestamp_ns = 0;
    Eigen::Isometry3d T_reference_body = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
};

// Returns a pair for every estimated pose with ground truth; the others are left out.
std::vector<PosePair> pair_poses(const types::Trajectory& estimate,
                                 const types::Trajectory& reference,
                                 const TrajectoryErrorOptions& options);

// Returns the interpolated pose at a moment; nullopt where the options do not allow interpolation.
std::optional<Eigen::Isometry3d> pose_at(const types::Trajectory& trajectory,
                                         std::int64_t timestamp_ns,
                                         const TrajectoryErrorOptions& options = {});

}  // namespace divemesh::evaluation
