#pragma once

#include <cstdint>

namespace divemesh::types {

// Counts of loop candidates (pairs of keyframes that may show the same place): considered, matched
// by geometry, and accepted.
struct LoopStatistics {
    std::int64_t num_candidates = 0;
    std::int64_t num_matched = 0;
    std::int64_t num_accepted = 0;
    double largest_correction_m = 0.0;  // of the track, by an accepted loop
    // Residual of the accepted loops in the final trajectory, RMS: in m, and in sigmas per axis.
    double residual_m = 0.0;
    double residual_sigmas = 0.0;
};

}  // namespace divemesh::types
