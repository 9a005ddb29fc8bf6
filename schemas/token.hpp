#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace divemesh {

// A bearer token as the catalog knows it: only its hash is stored.
struct Token {
    std::string id;
    std::string name;
    std::string project;
    std::vector<std::string> scopes;  // dives:read, dives:write, jobs:write, admin
    std::string secret_sha256;
    std::int64_t created_at_ms = 0;
    std::int64_t last_used_at_ms = 0;  // 0: never
    bool revoked = false;

    // admin allows everything.
    bool allows(const std::string& scope) const;
};

}  // namespace divemesh
