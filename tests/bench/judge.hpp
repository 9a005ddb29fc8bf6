#pragma once

#include <nlohmann/json.hpp>

#include "tests/bench/plan.hpp"

namespace divemesh::bench {

// Returns a goal with its measured value and whether it is met, from the runs of its group without
// ablation. A dive without a result (absent, failed, not selected) leaves the goal unmet.
nlohmann::json judge(const Goal& goal, const nlohmann::json& runs);

// Compares the median track life of features on the simulated barges with that on the recorded
// barge of the shared data. `within_30_percent` says whether their ratio is within 30 % of one.
// Returns null if either was not run.
nlohmann::json compare_track_life(const nlohmann::json& runs);

}  // namespace divemesh::bench
