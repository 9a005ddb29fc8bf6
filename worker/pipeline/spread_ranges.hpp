#pragma once

#include "worker/base/observer.hpp"
#include "worker/calibration/range_problem.hpp"
#include "worker/pipeline/pair_matcher.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::pipeline {

// Returns what ranges tell about `rig`, with which images are rectified: from windows spread over
// the span, more and more of them until they suffice. `sigmas` are those of the prior.
calibration::RangeSolution solve_spread_ranges(const types::Recording& recording,
                                               const types::Rig& rig,
                                               const FrameSpan& span,
                                               const calibration::RangeUnknowns& sigmas,
                                               int num_threads,
                                               const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
