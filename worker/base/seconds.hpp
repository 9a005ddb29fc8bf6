#pragma once

#include <cmath>
#include <cstdint>

namespace divemesh::base {

// Returns seconds.
inline double to_s(std::int64_t nanoseconds) { return static_cast<double>(nanoseconds) * 1e-9; }

// Returns whole nanoseconds, rounded to the nearest.
inline std::int64_t to_ns(double seconds) {
    return static_cast<std::int64_t>(std::llround(seconds * 1e9));
}

}  // namespace divemesh::base
