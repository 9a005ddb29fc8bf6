#pragma once

#include <cstdint>
#include <vector>

#include "worker/types/breaks.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// A part of the dive with connected poses. Its pose relative to the other segments is unknown.
struct TrackingSegment {
    struct Interval {
        std::int64_t first_ns = 0;
        std::int64_t last_ns = 0;
    };
    std::int64_t num_frames = 0;
    std::int64_t num_keyframes = 0;
    double path_length_m = 0.0;
    std::vector<Interval> intervals;  // of the frames; more than one if a loop rejoined them

    bool contains(std::int64_t timestamp_ns) const;
};

// Returns the segment number of every frame. A frame belongs to the segment of the last keyframe
// before it; the frames before the first keyframe, and those between a break (`breaks_ns`) and the
// next keyframe, belong to that keyframe's.
std::vector<std::size_t> segment_numbers(const types::Trajectory& trajectory,
                                         const std::vector<types::Keyframe>& keyframes,
                                         const types::Breaks& breaks_ns = {});

// Returns the segments in the order of their numbers. A motion that was not measured does not count
// towards the path.
std::vector<TrackingSegment> segments_of(const types::Trajectory& trajectory,
                                         const std::vector<types::Keyframe>& keyframes,
                                         const types::Breaks& breaks_ns = {});

// Returns the frames of the segment that has the most.
types::Trajectory largest_segment(const types::Trajectory& trajectory,
                                  const std::vector<types::Keyframe>& keyframes,
                                  const types::Breaks& breaks_ns = {});

}  // namespace divemesh::evaluation
