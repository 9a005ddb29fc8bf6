#pragma once

#include <cstdint>

namespace divemesh::types {

// Two keyframes that may show the same place: looked at, found to by geometry, believed.
struct LoopStatistics {
    std::int64_t num_candidates = 0;
    std::int64_t num_matched = 0;
    std::int64_t num_accepted = 0;
    double largest_correction_m = 0.0;  // by an accepted one, of where the track saw itself
    // What the final trajectory leaves of the accepted ones, RMS: m, and in sigmas per axis.
    double residual_m = 0.0;
    double residual_sigmas = 0.0;
};

}  // namespace divemesh::types
