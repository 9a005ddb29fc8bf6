#pragma once

#include "worker/base/observer.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig_alignment.hpp"

namespace divemesh::pipeline {

// Returns how the right camera stands against the left one, and in which medium both were
// calibrated, by the images alone: pairs spread over the dive are rectified with the stated
// calibration and matched, until enough points are found. If disparities are far off, it is
// repeated with cameras as they would be in another medium, and what fits much better is taken.
// Throws Error{BadData} if the stated cameras cannot be rectified.
types::RigAlignment align_cameras(const types::Recording& recording,
                                  int num_threads,
                                  const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
