#pragma once

#include <nlohmann/json.hpp>

#include "worker/pipeline/reconstruction.hpp"

namespace divemesh::pipeline {

// Returns the evaluation against the truth that the dive contains: trajectory, reference surface
// and distances.
evaluation::Evaluation compare_with_truth(const Reconstruction& made);

// Returns the content of metrics.json.
nlohmann::json metrics_of(const Reconstruction& made);

}  // namespace divemesh::pipeline
