#include "worker/optimisation/irls_outcome.hpp"

#include <cmath>

namespace divemesh::optimisation {
namespace {

constexpr double kConverged = 0.1;   // sigmas
constexpr double kTolerance = 1e-3;  // of the cost

}  // namespace

types::SolverOutcome outcome_of(const IrlsSteps& steps) {
    using Termination = types::SolverOutcome::Termination;
    types::SolverOutcome outcome;
    outcome.num_iterations = steps.num_steps;
    outcome.initial_cost = steps.initial_cost;
    outcome.final_cost = steps.final_cost;
    outcome.last_step_sigmas = steps.last_step_sigmas;
    if (!std::isfinite(steps.final_cost) || !std::isfinite(steps.last_step_sigmas)) {
        outcome.message = "the unknowns are not finite";
    } else if (steps.final_cost > (1.0 + kTolerance) * steps.initial_cost) {
        outcome.message = "the measurements fit less well than at the start";
    } else if (steps.last_step_sigmas < kConverged) {
        outcome.termination = Termination::Converged;
        outcome.message = "the last step was small";
    } else {
        outcome.termination = Termination::StoppedAtLimit;
        outcome.message = "the last step was still large";
    }
    return outcome;
}

}  // namespace divemesh::optimisation
