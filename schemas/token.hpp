#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// What a token may do. admin allows everything; sensor:push belongs to the tokens of one sensor.
inline constexpr std::array<std::string_view, 7> kScopes = {"dives:read",
                                                            "dives:write",
                                                            "jobs:write",
                                                            "sensor:push",
                                                            "sensor:command",
                                                            "metrics:read",
                                                            "admin"};

// Returns whether a text may name a project or a sensor: safe in URLs, files and logs, 1 to 63 of
// a-z, 0-9, '-' and '_', beginning with a letter or digit.
bool is_plain_word(std::string_view text);

// A bearer token as the catalog stores it: with its hash only.
struct Token {
    std::string id;
    std::string name;
    std::string project;
    std::vector<std::string> scopes;  // of kScopes
    std::string sensor;               // the only sensor it may push for; "" without sensor:push
    std::string shared_job;           // a sharing link: the only job that it may read; "": any
    std::string shared_dive;          // the dive of that job
    std::string secret_sha256;
    std::int64_t created_at_ms = 0;
    std::int64_t last_used_at_ms = 0;  // 0: never
    std::int64_t expires_at_ms = 0;    // 0: never
    bool revoked = false;

    // admin allows everything.
    bool allows(std::string_view scope) const;
};

}  // namespace divemesh
