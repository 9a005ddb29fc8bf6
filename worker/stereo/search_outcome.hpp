#pragma once

#include <cstdint>

#include "worker/stereo/disparity_range.hpp"

namespace divemesh::worker {

// What a search over a whole picture came to. A winner that nothing else comes near is clear; one
// at an end of the range, where what lies beyond may be better, is clipped.
struct SearchOutcome {
    DisparityRange range;
    std::int64_t num_clear = 0;  // 0: the matcher does not tell
    std::int64_t num_clipped = 0;
};

// The same of many pictures.
struct SearchStatistics {
    std::int64_t num_frames = 0;
    std::int64_t sum_ranges_px = 0;  // disparities looked for
    std::int64_t num_clear = 0;
    std::int64_t num_clipped = 0;

    void add(const SearchOutcome& outcome) {
        add(SearchStatistics{1, outcome.range.num_px, outcome.num_clear, outcome.num_clipped});
    }
    void add(const SearchStatistics& other) {
        num_frames += other.num_frames;
        sum_ranges_px += other.sum_ranges_px;
        num_clear += other.num_clear;
        num_clipped += other.num_clipped;
    }
};

}  // namespace divemesh::worker
