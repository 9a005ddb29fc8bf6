#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

#include "schemas/token.hpp"

namespace divemesh::api {

// Tokens that were asked for within the last second, so that a busy client's are not looked up for
// each of its requests. Whoever revokes a token in this process clears it; what another process
// revokes opens doors here for a second more. Bounded. Thread-safe.
class TokenCache {
public:
    std::optional<Token> find(const std::string& secret_sha256);
    void put(const Token& token);
    void clear();

private:
    struct Entry {
        Token token;
        std::chrono::steady_clock::time_point until;
    };
    std::mutex mutex_;
    std::unordered_map<std::string, Entry> entries_;  // by secret_sha256
};

}  // namespace divemesh::api
