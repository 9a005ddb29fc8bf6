#pragma once

#include <cstdint>
#include <string>

namespace divemesh {

// A link that opens the result of one job for reading until it expires or is withdrawn. It is a
// token with a secret of its own.
struct Share {
    std::string id;
    std::string job_id;
    std::string name;
    std::int64_t created_at_ms = 0;
    std::int64_t last_used_at_ms = 0;  // 0: never
    std::int64_t expires_at_ms = 0;
    bool withdrawn = false;
};

}  // namespace divemesh
