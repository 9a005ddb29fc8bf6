#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "schemas/token.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// How long a session lasts: without a request, and in all.
inline constexpr std::chrono::hours kSessionIdle{24};
inline constexpr std::chrono::hours kSessionLifetime{24 * 30};

// A browser that is signed in with a token.
struct BrowserSession {
    Token token;
    std::int64_t expires_at_ms = 0;  // at the latest: kSessionIdle may end it before
};

struct CreatedSession {
    BrowserSession session;
    std::string secret;  // 64 hex digits: the cookie, stored as its hash
};

// The sessions of the web page. A session has the rights of its token, and ends with it.
class BrowserSessionStore {
public:
    explicit BrowserSessionStore(Catalog& catalog) : catalog_(catalog) {}

    // Begins a session. A token has at most 100: its oldest one ends where there are more.
    CreatedSession create(const Token& token);
    // Begins one for the owner of a one-shot token for `path`, which is used up; nullopt if it was
    // used, has expired or is for another path.
    std::optional<CreatedSession> redeem(const std::string& one_shot, const std::string& path);
    // Returns the session if neither it nor its token has ended; otherwise nullopt. Writes once a
    // minute that it was used; a catalog that may not wait throws Error{Unavailable} then.
    std::optional<BrowserSession> find(const std::string& secret);
    void end(const std::string& secret);  // does nothing if there is none
    void forget_ended();

private:
    void record_use(const std::string& hash, const std::string& token_id, std::int64_t now_ms);

    Catalog& catalog_;
};

}  // namespace divemesh::storage
