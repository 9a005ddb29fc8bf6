#include "worker/io/solver_json.hpp"

namespace divemesh::io {
namespace {

const char* to_string(types::SolverOutcome::Termination termination) {
    using Termination = types::SolverOutcome::Termination;
    switch (termination) {
        case Termination::Converged: return "converged";
        case Termination::StoppedAtLimit: return "stopped_at_limit";
        case Termination::Failed: return "failed";
    }
    return "";
}

}  // namespace

nlohmann::json to_json(const types::SolverOutcome& outcome) {
    return {{"outcome", to_string(outcome.termination)},
            {"num_iterations", outcome.num_iterations},
            {"initial_cost", outcome.initial_cost},
            {"final_cost", outcome.final_cost}};
}

nlohmann::json to_json(const types::SolverTally& tally) {
    return {{"num_solves", tally.num_solves},
            {"num_converged", tally.num_converged},
            {"num_stopped_at_limit", tally.num_stopped_at_limit},
            {"num_still_moving", tally.num_still_moving},
            {"num_failed", tally.num_failed},
            {"num_iterations", tally.num_iterations},
            {"initial_cost", tally.initial_cost},
            {"final_cost", tally.final_cost}};
}

}  // namespace divemesh::io
