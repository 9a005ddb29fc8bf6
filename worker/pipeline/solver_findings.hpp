#pragma once

#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/solver_outcome.hpp"
#include "worker/types/track.hpp"

// What the user is told about how tracking and adjusting went, and when the result is no model.
namespace divemesh::pipeline {

// Throws Error{BadData} when next to no frame was constrained by vision.
void require_tracked(const types::TrackStatistics& track);

// Returns what is to be said about frames without vision and about the solvers of the tracking.
std::vector<Finding> tracking_findings(const types::TrackStatistics& track);

// Returns a warning about a solve that failed, or that stopped at its limit while its cost was
// still falling; empty: neither. `code` names the finding, `what` the solve.
std::vector<Finding> solver_findings(const types::SolverOutcome& outcome,
                                     const std::string& code,
                                     const std::string& what);

// Throws Error{BadData} when the result cannot be right: values that are not finite, landmarks that
// no longer project to where they were seen, a path far longer than that of the odometry.
void require_converged(const types::Track& track, const types::OptimisedTrack& result);

}  // namespace divemesh::pipeline
