#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "tests/bench/plan.hpp"

namespace divemesh::bench {

double median(std::vector<double> values);

// A goal with what was measured: over the runs of its group without ablation. Dives that were not
// measured (absent, failed, not asked for) leave it unmet.
nlohmann::json judge(const Goal& goal, const nlohmann::json& runs);

// How long features are followed on the simulated barges, against the shared one: as hard when the
// ratio of the medians is within 30 % of one. Null when a side was not run.
nlohmann::json compare_track_life(const nlohmann::json& runs);

}  // namespace divemesh::bench
