#pragma once

#include <vector>

#include "schemas/finding.hpp"
#include "worker/types/rig_alignment.hpp"

namespace divemesh::pipeline {

// Returns what a user must know of where the right camera stands: nothing when the stated
// calibration fits.
std::vector<Finding> alignment_findings(const types::RigAlignment& alignment);

}  // namespace divemesh::pipeline
