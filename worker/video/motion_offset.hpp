#pragma once

#include <optional>

#include "worker/base/observer.hpp"
#include "worker/video/clock_offset.hpp"
#include "worker/video/video_index.hpp"

namespace divemesh::video {

// Finds how two videos differ by how their images move as a whole in their first minute; nullopt if
// that is not clear.
std::optional<ClockOffset> offset_by_motion(const IndexedVideo& left,
                                            const IndexedVideo& right,
                                            const base::ProgressCallback& progress);

}  // namespace divemesh::video
