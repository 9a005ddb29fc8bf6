#pragma once

#include <vector>

#include "schemas/finding.hpp"
#include "worker/base/observer.hpp"

namespace divemesh::types {
class Recording;
}

namespace divemesh::pipeline {

// The check of an intake: align_cameras() with findings alone. Cameras that cannot be rectified
// have none.
std::vector<Finding> check_cameras(const types::Recording& recording,
                                   const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
