#pragma once

#include <cstdint>
#include <vector>

#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// Notes which pairs of a dive could not be used, from the frames that were.
class UnusablePairLog {
public:
    // Takes in the next usable frame; `index` is its number among all pairs.
    void add_frame(std::int64_t index, std::int64_t timestamp_ns);
    // Returns the runs of unusable pairs among `num_pairs`. One at an end of the dive, where no
    // frame tells its time, lasts as long as as many frames usually do.
    std::vector<types::UnusablePairs> finish(std::int64_t num_pairs);

private:
    std::vector<types::UnusablePairs> runs_;
    std::int64_t num_frames_ = 0;
    std::int64_t next_index_ = 0;
    std::int64_t first_index_ = 0;
    std::int64_t first_ns_ = 0;
    std::int64_t last_ns_ = 0;
};

}  // namespace divemesh::pipeline
