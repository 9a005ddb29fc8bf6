#pragma once

#include <vector>

#include "worker/base/observer.hpp"
#include "worker/pipeline/pair_matcher.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig_alignment.hpp"
#include "worker/types/stereo_match.hpp"

namespace divemesh::pipeline {

// Returns the spans of the dive within which the right camera stays where it is on the rig: one,
// unless the rows of `matches` jump from one frame to the next. `matches` are of pairs spread over
// the dive, as rectified with `rig`; further pairs are read only if these jump.
std::vector<FrameSpan> still_spans(const types::Recording& recording,
                                   const types::Rig& rig,
                                   const types::StereoMatches& matches,
                                   int num_threads,
                                   const base::ProgressCallback& progress);

// Returns how the right camera is turned in each of the spans against the `reference` among them,
// whose cameras `rig` describes.
std::vector<types::RigPart> align_parts(const types::Recording& recording,
                                        const types::Rig& rig,
                                        const std::vector<FrameSpan>& spans,
                                        const FrameSpan& reference,
                                        int num_threads,
                                        const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
