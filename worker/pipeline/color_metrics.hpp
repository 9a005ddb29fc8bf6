#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "schemas/finding.hpp"
#include "worker/pipeline/water_color.hpp"

namespace divemesh::pipeline {

// Returns the section "color" of metrics.json.
nlohmann::json to_metrics(const WaterColor& color);

// Returns a warning if colours were to be restored, but stay as recorded.
std::optional<Finding> color_finding(const WaterColor& color);

}  // namespace divemesh::pipeline
