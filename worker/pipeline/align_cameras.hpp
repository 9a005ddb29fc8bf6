#pragma once

#include "worker/base/observer.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig_alignment.hpp"

namespace divemesh::pipeline {

// Returns the pose of the right camera relative to the left one, and the medium in which both were
// calibrated, estimated from the images alone. Pairs spread over the dive are rectified with the
// stated calibration and matched until there are enough points. If the disparities are far off,
// this is repeated for other media, and the one that fits much better is taken. Cameras behind
// described ports are rectified for the median depth of the survey, which is returned too. Throws
// Error{BadData} if the stated cameras cannot be rectified.
types::RigAlignment align_cameras(const types::Recording& recording,
                                  int num_threads,
                                  const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
