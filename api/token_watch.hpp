#pragma once

#include <chrono>
#include <string>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Watches the token of a request or stream that lasts: a token that is revoked or expires meanwhile
// must not go on for hours. Asks the catalog at most once a second.
class TokenWatch {
public:
    // The token was valid just now; "": no authentication, always valid.
    explicit TokenWatch(std::string token_id) : token_id_(std::move(token_id)) {}

    bool is_valid(storage::Catalog& catalog);         // may block
    Awaitable<bool> is_valid_now(Services services);  // asks in the pool

private:
    bool is_trusted() const;

    std::string token_id_;
    std::chrono::steady_clock::time_point asked_at_ = std::chrono::steady_clock::now();
};

}  // namespace divemesh::api
