#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "worker/reef/area_metrics.hpp"
#include "worker/reef/measure_outline.hpp"
#include "worker/stats/estimate.hpp"

namespace divemesh::reef {

// Return one entry of "figures".
nlohmann::json metric_json(const AreaTask& task,
                           const MetricKind& kind,
                           const stats::Estimate& estimate);
nlohmann::json refused_json(const AreaTask& task,
                            const MetricKind& kind,
                            const std::string& reason);

}  // namespace divemesh::reef
