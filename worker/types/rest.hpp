#pragma once

#include <cstdint>

namespace divemesh::types {

// A time in which the rig stood still or nearly so, from the first frame to the last, and how well
// the last one's pose is known against the first's.
struct Rest {
    std::int64_t from_ns = 0;
    std::int64_t to_ns = 0;
    double sigma_m = 0.0;    // along each axis
    double sigma_rad = 0.0;  // about each axis
};

}  // namespace divemesh::types
