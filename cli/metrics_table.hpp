#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace divemesh::cli {

// Returns the main metrics of a metrics.json: one line each, with its unit. Leaves out what the
// file lacks (no ground truth, no reference mesh).
std::string metrics_summary(const nlohmann::json& metrics);

// Returns every metric, one line each by its name in the file: "trajectory.ate_rmse_m". Leaves out
// options and findings. Up to four numbers in a list are one line.
std::string metrics_table(const nlohmann::json& metrics);

}  // namespace divemesh::cli
