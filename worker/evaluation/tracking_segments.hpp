#pragma once

#include <cstdint>
#include <vector>

#include "worker/types/keyframe.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// A part of the dive that hangs together. Where it lies against the others is not known.
struct TrackingSegment {
    struct Interval {
        std::int64_t first_ns = 0;
        std::int64_t last_ns = 0;
    };
    std::int64_t num_frames = 0;
    std::int64_t num_keyframes = 0;
    double path_length_m = 0.0;
    std::vector<Interval> intervals;  // of the frames; more than one: joined again by a loop
};

// The pieces in the order of their numbers. A frame belongs to the piece of the last keyframe
// before it, the frames before the first keyframe to that one's.
std::vector<TrackingSegment> segments_of(const types::Trajectory& trajectory,
                                         const std::vector<types::Keyframe>& keyframes);

// The frames of the piece that has most of them.
types::Trajectory largest_segment(const types::Trajectory& trajectory,
                                  const std::vector<types::Keyframe>& keyframes);

}  // namespace divemesh::evaluation
