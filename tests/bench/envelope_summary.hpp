#pragma once

#include <nlohmann/json.hpp>

#include "tests/bench/envelope_plan.hpp"

namespace divemesh::bench {

// Returns one row for each step of an axis that was run: axis, step, num_runs, num_working; median
// and worst tracked_share, ate_percent (of the path), bound_percent, scale_error and ratio (error
// to bound); findings and verdicts with their number; exit codes; linked_share and ate_percent of
// SIFT.
nlohmann::json summarise(const EnvelopeAxis& axis, const nlohmann::json& runs);

}  // namespace divemesh::bench
