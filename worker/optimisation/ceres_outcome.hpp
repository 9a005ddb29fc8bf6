#pragma once

#include <ceres/solver.h>

#include "worker/types/solver_outcome.hpp"

namespace divemesh::optimisation {

// Returns the outcome that corresponds to Ceres' summary of a solve whose residuals are in standard
// deviations.
types::SolverOutcome outcome_of(const ceres::Solver::Summary& summary);

}  // namespace divemesh::optimisation
