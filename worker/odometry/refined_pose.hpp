#pragma once

#include <Eigen/Geometry>

#include "worker/types/solver_outcome.hpp"

namespace divemesh::odometry {

// The result of step 6: the motion, and how the solver ended. If the solver failed, the motion is
// the best one found before; at worst it is the guess.
struct RefinedPose {
    Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();
    types::SolverOutcome outcome;
};

}  // namespace divemesh::odometry
