#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// The criteria for a run of the envelope. A run is one JSON object: axis, step, scene, seed,
// exit_code, num_frames, tracked_share, path_m, ate_m, bound_m, scale, verdict, findings (codes of
// warnings and errors). A value that the run did not state is null.
namespace divemesh::bench {

// Returns whether a run succeeded: exit code 0, at least nine of ten frames tracked and an error of
// at most 0.5 % of the path.
bool works(const nlohmann::json& run);

// Returns whether the error is more than three times the stated bound, whatever the run says.
bool breaks_bound(const nlohmann::json& run);

// Returns whether a run failed without saying so: its error breaks its bound (or error or bound is
// missing and works() is false), while exit code, verdict and findings report no problem.
bool is_silent(const nlohmann::json& run);

// Returns whether the exit code is 0 although less than a tenth of the frames is tracked.
bool is_hollow_success(const nlohmann::json& run);

// Returns {last_good, first_bad} of an ordered axis: the first step that any run fails, and the
// step before it; null where there is no such step.
nlohmann::json edge_of(const std::vector<std::string>& steps, const nlohmann::json& runs);

}  // namespace divemesh::bench
