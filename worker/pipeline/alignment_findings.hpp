#pragma once

#include <vector>

#include "schemas/finding.hpp"
#include "worker/types/rig_alignment.hpp"

namespace divemesh::pipeline {

// Returns the findings about the right camera's pose and the medium of the calibration; empty if
// the stated calibration fits.
std::vector<Finding> alignment_findings(const types::RigAlignment& alignment);

}  // namespace divemesh::pipeline
