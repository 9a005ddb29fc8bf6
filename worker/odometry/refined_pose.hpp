#pragma once

#include <Eigen/Geometry>

#include "worker/types/solver_outcome.hpp"

namespace divemesh::odometry {

// What step 6 gives: the motion, and how the solver ended. Where it failed, the best motion by
// then, at worst the guess.
struct RefinedPose {
    Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();
    types::SolverOutcome outcome;
};

}  // namespace divemesh::odometry
