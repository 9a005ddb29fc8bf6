#pragma once

#include "worker/types/solver_outcome.hpp"

namespace divemesh::optimisation {

// How iteratively reweighted least squares (IRLS) of a fixed number of steps went.
struct IrlsSteps {
    int num_steps = 0;
    // Robust loss at the scale of the last step, so that both are of one function.
    double initial_cost = 0.0;
    double final_cost = 0.0;
    double last_step_sigmas = 0.0;  // RMS over the unknowns
};

// Returns how they ended: converged if the last step moved the unknowns by less than a tenth of
// their standard deviations, failed if they are not finite or fit less well than at the start by
// more than rounding and changed weights explain.
types::SolverOutcome outcome_of(const IrlsSteps& steps);

}  // namespace divemesh::optimisation
