#pragma once

#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/solver_outcome.hpp"
#include "worker/types/track.hpp"

// What the user is told about tracking and optimisation, and the checks that fail a job whose
// result is not a usable model.
namespace divemesh::pipeline {

// Throws Error{BadData} if hardly any frame was constrained by vision.
void require_tracked(const types::TrackStatistics& track);

// Returns the findings about frames that vision did not constrain and about failures of the solvers
// during tracking.
std::vector<Finding> tracking_findings(const types::TrackStatistics& track);

// Returns a warning if a solve failed, or if it stopped at its limit while its cost was still
// falling; otherwise an empty list. `code` is the code of the finding, `what` names the solve in
// its message.
std::vector<Finding> solver_findings(const types::SolverOutcome& outcome,
                                     const std::string& code,
                                     const std::string& what);

// Throws Error{BadData} if the result cannot be right: a pose is not finite, the landmarks have a
// large reprojection error, or the path is far longer than that of the odometry.
void require_converged(const types::Track& track, const types::OptimisedTrack& result);

}  // namespace divemesh::pipeline
