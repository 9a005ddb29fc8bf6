#pragma once

#include <chrono>
#include <cstdint>

namespace divemesh {

// Returns unix milliseconds by this machine's clock, which may be wrong.
inline std::int64_t wall_time_ms() {
    return std::chrono::duration_cast<std::chrono::milliseconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
}

}  // namespace divemesh
