#pragma once

#include <vector>

#include "schemas/finding.hpp"
#include "worker/base/observer.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig_alignment.hpp"

namespace divemesh::pipeline {

// Returns how the right camera stands against the left one, by the images alone: pairs spread over
// the dive are rectified with the stated calibration and matched, until enough points are found.
// Throws Error{BadData} if the stated cameras cannot be rectified.
types::RigAlignment align_cameras(const types::Recording& recording,
                                  int num_threads,
                                  const base::ProgressCallback& progress);

// Returns what a user must know of it: nothing when the stated calibration fits.
std::vector<Finding> alignment_findings(const types::RigAlignment& alignment);

}  // namespace divemesh::pipeline
