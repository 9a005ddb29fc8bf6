#pragma once

#include <nlohmann/json.hpp>

#include "worker/pipeline/reconstruction.hpp"

namespace divemesh::pipeline {

// With what the dive itself knows better: its true trajectory, reference surface and distances.
evaluation::Evaluation compare_with_truth(const Reconstruction& made);

// metrics.json.
nlohmann::json metrics_of(const Reconstruction& made);

}  // namespace divemesh::pipeline
