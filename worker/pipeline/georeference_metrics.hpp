#pragma once

#include <nlohmann/json.hpp>

#include "worker/types/georeference.hpp"

namespace divemesh::pipeline {

// Returns the section georeference of metrics.json.
nlohmann::json to_metrics(const types::GeoReference& georeference);

}  // namespace divemesh::pipeline
