#pragma once

#include <cstdint>

#include "worker/types/disparity_range.hpp"

namespace divemesh::types {

// The disparity search range of an image, and how many patches of its survey
// (CoarseDisparitySearch) lie outside the range: a search within a range cannot count what it
// misses.
struct SearchOutcome {
    DisparityRange range;
    std::int64_t num_patches = 0;
    std::int64_t num_too_far = 0;
    std::int64_t num_too_near = 0;
};

// The same, summed over many images.
struct SearchStatistics {
    std::int64_t num_frames = 0;
    std::int64_t sum_ranges_px = 0;  // searched disparities
    std::int64_t num_patches = 0;
    std::int64_t num_too_far = 0;
    std::int64_t num_too_near = 0;

    void add(const SearchOutcome& outcome) {
        add(SearchStatistics{1,
                             outcome.range.num_px,
                             outcome.num_patches,
                             outcome.num_too_far,
                             outcome.num_too_near});
    }
    void add(const SearchStatistics& other) {
        num_frames += other.num_frames;
        sum_ranges_px += other.sum_ranges_px;
        num_patches += other.num_patches;
        num_too_far += other.num_too_far;
        num_too_near += other.num_too_near;
    }
};

}  // namespace divemesh::types
