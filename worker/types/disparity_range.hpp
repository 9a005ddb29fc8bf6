#pragma once

namespace divemesh::types {

// The disparities that a matcher searches: first_px, first_px + 1, ..., `num_px` of them.
struct DisparityRange {
    int first_px = 0;
    int num_px = 0;
};

}  // namespace divemesh::types
