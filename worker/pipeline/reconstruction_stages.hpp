#pragma once

#include <vector>

#include "worker/pipeline/reconstruction.hpp"
#include "worker/pipeline/stage.hpp"

namespace divemesh::pipeline {

// Returns the table of stages in running order. The keys of the stage store, progress, the names in
// metrics.json and the loop over a dive all come from it.
std::vector<Stage<Reconstruction>> reconstruction_stages();

}  // namespace divemesh::pipeline
