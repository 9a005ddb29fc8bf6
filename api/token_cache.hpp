#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

#include "schemas/token.hpp"

namespace divemesh::api {

// Tokens looked up within the last second, so that a busy client's token is not read for each
// request. The code that revokes a token in this process clears the cache; a token that another
// process revokes works here for up to a second more. Bounded. Thread-safe.
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
