#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace divemesh::cli {

// What a person wants to know first of a metrics.json: a line each, with its unit. What the file
// lacks (no ground truth, no reference mesh) is left out.
std::string metrics_summary(const nlohmann::json& metrics);

// Every figure, one line each by its name in the file: "trajectory.ate_rmse_m". Options and
// findings are left out. Up to four numbers in a list are one line.
std::string metrics_table(const nlohmann::json& metrics);

}  // namespace divemesh::cli
