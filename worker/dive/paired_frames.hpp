#pragma once

#include <cstdint>
#include <vector>

#include "worker/dive/frame_list.hpp"
#include "worker/dive/stereo_delay.hpp"

namespace divemesh::dive {

// What timestamps and images say about the gap between the exposures of a pair. It varies if
// cameras run free, or their triggers jitter.
enum class PairGaps {
    Constant,     // by the timestamps it is the same for all pairs, as far as it matters
    Stated,       // it varies by the timestamps; the images show too little to tell
    Confirmed,    // it varies, and the images fit better with it
    Contradicted  // it varies by the timestamps, but the images fit better without
};

// The frames of a dive, paired by timestamps and images.
struct PairedFrames {
    std::vector<FramePair> pairs;
    ClockDifference clocks;
    PairGaps gaps = PairGaps::Constant;
    StereoDelay delay;             // between the images of a pair; beyond its gap if that is used
    std::vector<int> moments;      // the pairs of delay.by_moment_s
    bool has_right_clock = false;  // timestamps of the pairs are by the right clock

    // Returns the gap by the timestamps, without the difference of the clocks: right minus left.
    std::int64_t gap_ns(const FramePair& pair) const;
    // Returns whether the gaps of more than a few pairs differ from the others by the timestamps.
    bool gaps_vary() const;
    bool uses_gaps() const { return gaps == PairGaps::Stated || gaps == PairGaps::Confirmed; }
    // Returns how much later the right image of a pair was exposed, by timestamps and images; 0 if
    // neither shows a difference that matters.
    double right_delay_s(const FramePair& pair) const;
    // Returns the standard deviation of how far the rig moves during the part of that delay which
    // all pairs share, m; 0 if all pairs count as exposed together.
    double shared_delay_sigma_m() const;
};

// Gives the pairs the timestamps of the right clock, where the other sensors follow that.
void use_right_clock(PairedFrames& frames);

}  // namespace divemesh::dive
