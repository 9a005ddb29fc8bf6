#pragma once

#include <chrono>
#include <cstdint>

namespace divemesh::api {

// Returns this machine's clock in unix milliseconds.
inline std::int64_t now_ms() {
    return std::chrono::duration_cast<std::chrono::milliseconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
}

}  // namespace divemesh::api
