#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "worker/reef/area_figures.hpp"
#include "worker/reef/estimate.hpp"
#include "worker/reef/measure_outline.hpp"

namespace divemesh::worker {

// One entry of "figures".
nlohmann::json figure_json(const AreaTask& task, const FigureKind& kind, const Estimate& estimate);
nlohmann::json refused_json(const AreaTask& task,
                            const FigureKind& kind,
                            const std::string& reason);

}  // namespace divemesh::worker
