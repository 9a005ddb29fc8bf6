#pragma once

#include <nlohmann/json.hpp>

#include "worker/types/solver_outcome.hpp"

namespace divemesh::io {

// Returns how one solve ended, as our JSON files have it: outcome (converged, stopped_at_limit,
// failed), num_iterations, initial_cost, final_cost.
nlohmann::json to_json(const types::SolverOutcome& outcome);

// Returns the counts of the outcomes of all solves of one kind, under the names of SolverTally.
nlohmann::json to_json(const types::SolverTally& tally);

}  // namespace divemesh::io
