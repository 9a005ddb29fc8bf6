#pragma once

#include <optional>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/base/observer.hpp"

namespace divemesh::types {
class Recording;
}

namespace divemesh::pipeline {

// Returns an error if the stated cameras share too little of their fields of view to be rectified.
// Expects a rig without an error in its own findings, whose right camera is on the right.
std::optional<Finding> find_no_overlap(const types::Recording& recording);

// The check of an intake: align_cameras() with findings alone. Cameras that cannot be rectified,
// as stated or as aligned, are an error.
std::vector<Finding> check_cameras(const types::Recording& recording,
                                   const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
