#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace divemesh::types {

// The timestamps, ascending, of the frames whose motion since the frame before was not measured.
// The distance between the two is a guess.
using Breaks = std::vector<std::int64_t>;

// Returns true if the motion to the frame of this timestamp was not measured.
inline bool is_break(const Breaks& breaks_ns, std::int64_t timestamp_ns) {
    return std::binary_search(breaks_ns.begin(), breaks_ns.end(), timestamp_ns);
}

}  // namespace divemesh::types
