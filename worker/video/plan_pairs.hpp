#pragma once

#include <cstdint>
#include <vector>

#include "worker/video/clock_offset.hpp"

namespace divemesh::video {

// Two frames that were exposed nearly together, each by the clock of its own video.
struct PlannedPair {
    std::int64_t left_ns = 0;
    std::int64_t right_ns = 0;
};

// Chooses `rate_hz` pairs a second while both videos run: the left frame that is nearest to each
// moment, and the right frame that is nearest to that. A frame is in one pair at most, and frames
// that are further apart than frames of the slower video mostly are, are no pair. Stamps are
// ascending.
std::vector<PlannedPair> plan_pairs(const std::vector<std::int64_t>& left_ns,
                                    const std::vector<std::int64_t>& right_ns,
                                    const ClockOffset& clock,
                                    double rate_hz);

// The time between the frames of pairs, whichever is first.
struct PairTimes {
    double median_s = 0.0;
    double max_s = 0.0;
};

PairTimes times_between(const std::vector<PlannedPair>& pairs, const ClockOffset& clock);

}  // namespace divemesh::video
