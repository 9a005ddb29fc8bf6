#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// How a run of the envelope is judged. A run is one JSON: axis, step, scene, seed, exit_code,
// num_frames, tracked_share, path_m, ate_m, bound_m, scale, verdict, findings (codes from warning
// on); what was not stated is null.
namespace divemesh::bench {

// A run works when at least nine of ten frames are tracked and the error is at most 0.5 % of the
// path.
bool works(const nlohmann::json& run);

// A run is silent when its error is more than three times its stated bound (or no bound is stated
// and it does not work) and neither verdict nor finding says that something is wrong.
bool is_silent(const nlohmann::json& run);

// Less than a tenth of the frames is tracked, and the exit code is 0.
bool is_hollow_success(const nlohmann::json& run);

// The steps of an ordered axis that all runs of a scene and seed pass, up to the first that one
// fails: {last_good, first_bad}, null where there is none.
nlohmann::json edge_of(const std::vector<std::string>& steps, const nlohmann::json& runs);

}  // namespace divemesh::bench
