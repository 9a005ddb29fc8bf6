#pragma once

#include <cstddef>
#include <vector>

#include "worker/types/breaks.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/tracking_segment.hpp"

namespace divemesh::evaluation {

// Returns the segment number of every frame. A frame belongs to the segment of the last keyframe
// before it; the frames before the first keyframe, and those between a break (`breaks_ns`) and the
// next keyframe, belong to that keyframe's.
std::vector<std::size_t> segment_numbers(const types::Trajectory& trajectory,
                                         const std::vector<types::Keyframe>& keyframes,
                                         const types::Breaks& breaks_ns = {});

// Returns the segments in the order of their numbers. A motion that was not measured does not count
// towards the path.
std::vector<types::TrackingSegment> segments_of(const types::Trajectory& trajectory,
                                                const std::vector<types::Keyframe>& keyframes,
                                                const types::Breaks& breaks_ns = {});

// Returns the number of the segment that has the most frames, the first of equals; 0 without
// segments.
std::size_t number_of_largest(const std::vector<types::TrackingSegment>& segments);

// Returns the poses of a path of the dive, final or causal, that lie within the segment that has
// the most frames; all of them if there are fewer than two segments.
types::Trajectory within_largest(const types::Trajectory& trajectory,
                                 const std::vector<types::TrackingSegment>& segments);

}  // namespace divemesh::evaluation
