#pragma once

#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/solver_outcome.hpp"
#include "worker/types/track.hpp"

// Findings about the solvers of tracking and optimisation.
namespace divemesh::pipeline {

// Returns the findings about solvers that failed during tracking, and about motions between frames
// that stopped at their limit while still moving. The sliding window stops there on purpose.
std::vector<Finding> window_findings(const types::TrackStatistics& track);

// Returns a warning if a solve failed, or if it stopped at its limit while still moving; otherwise
// an empty list. `code` is the code of the finding, `what` names the solve in
// its message.
std::vector<Finding> solver_findings(const types::SolverOutcome& outcome,
                                     const std::string& code,
                                     const std::string& what);

// Returns an error if the result cannot be right: a pose is not finite, the landmarks have a large
// reprojection error, or the path is far longer than that of the odometry.
std::optional<Finding> divergence(const types::Track& track, const types::OptimisedTrack& result);

}  // namespace divemesh::pipeline
