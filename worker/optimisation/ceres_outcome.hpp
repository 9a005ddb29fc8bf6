#pragma once

#include <ceres/solver.h>

#include "worker/types/solver_outcome.hpp"

namespace divemesh::optimisation {

// Returns what Ceres says about a solve.
types::SolverOutcome outcome_of(const ceres::Solver::Summary& summary);

}  // namespace divemesh::optimisation
