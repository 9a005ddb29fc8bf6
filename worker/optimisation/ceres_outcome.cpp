#include "worker/optimisation/ceres_outcome.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::optimisation {
namespace {

types::SolverOutcome::Termination termination_of(ceres::TerminationType type) {
    switch (type) {
        case ceres::CONVERGENCE:
        case ceres::USER_SUCCESS: return types::SolverOutcome::Termination::Converged;
        case ceres::NO_CONVERGENCE: return types::SolverOutcome::Termination::StoppedAtLimit;
        case ceres::FAILURE:
        case ceres::USER_FAILURE: break;
    }
    return types::SolverOutcome::Termination::Failed;
}

}  // namespace

types::SolverOutcome outcome_of(const ceres::Solver::Summary& summary) {
    types::SolverOutcome outcome;
    outcome.termination = termination_of(summary.termination_type);
    outcome.initial_cost = summary.initial_cost;
    outcome.final_cost = summary.final_cost;
    outcome.message = summary.message;
    double last_decrease = 0.0;
    for (const ceres::IterationSummary& iteration : summary.iterations) {
        outcome.num_iterations = std::max(outcome.num_iterations, iteration.iteration);
        if (iteration.iteration > 0 && iteration.step_is_successful && iteration.cost > 0.0) {
            last_decrease = std::max(0.0, iteration.cost_change);
            outcome.last_decrease = last_decrease / iteration.cost;
        }
    }
    // Near its minimum the cost falls by half the squared length of a step, in sigmas.
    outcome.last_step_sigmas =
        std::sqrt(2.0 * last_decrease / std::max(1, summary.num_effective_parameters_reduced));
    return outcome;
}

}  // namespace divemesh::optimisation
