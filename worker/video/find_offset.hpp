#pragma once

#include <optional>

#include "worker/base/observer.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/video/clock_offset.hpp"
#include "worker/video/indexed_video.hpp"

namespace divemesh::video {

// Finds how the clocks of two videos differ: by the offset that a user states, by what both cameras
// heard, by the times at which both files were created if those are finer than a second, by how
// both images move, by timecodes, in this order. Reports which of these it is and how well it is
// known; where none tells, both videos are taken to begin together, with a warning.
ClockOffset find_offset(const IndexedVideo& left,
                        const IndexedVideo& right,
                        std::optional<double> stated_s,
                        dive::FindingLog& findings,
                        const base::ProgressCallback& progress);

}  // namespace divemesh::video
