#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace divemesh::stats {

// How RANSAC samples: limits of the number of its iterations.
struct RansacLimits {
    int sample_size = 3;
    double confidence = 0.999;
    int min_iterations = 1;
    int max_iterations = 100;
};

// Returns the number of iterations of RANSAC after which a sample of inliers alone has been drawn
// with probability `confidence`, within limits (Fischler and Bolles 1981).
inline int num_ransac_iterations(std::size_t num_inliers,
                                 std::size_t num_values,
                                 const RansacLimits& limits) {
    const double share = static_cast<double>(num_inliers) / static_cast<double>(num_values);
    const double miss = 1.0 - std::pow(share, limits.sample_size);
    if (!(miss < 1.0)) return limits.max_iterations;
    const double tries = std::ceil(std::log(1.0 - limits.confidence) / std::log(miss));
    return static_cast<int>(
        std::clamp<double>(tries, limits.min_iterations, limits.max_iterations));
}

}  // namespace divemesh::stats
