#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace divemesh::types {

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

    bool contains(std::int64_t timestamp_ns) const {
        return std::any_of(intervals.begin(), intervals.end(), [&](const Interval& interval) {
            return interval.first_ns <= timestamp_ns && timestamp_ns <= interval.last_ns;
        });
    }
};

}  // namespace divemesh::types
