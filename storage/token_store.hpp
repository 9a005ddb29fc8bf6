#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "schemas/token.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

struct NewToken {
    std::string name;
    std::string project = "default";
    std::vector<std::string> scopes;
    std::string sensor;                // required by sensor:push, not allowed otherwise
    std::chrono::seconds lifetime{0};  // 0: until it is revoked
};

struct CreatedToken {
    Token token;
    std::string secret;  // dm_<64 hex>: shown once, stored as its hash
};

// Opens one path once, for a browser that cannot send a header.
struct OneShotToken {
    std::string secret;  // dm1_<64 hex>
    std::string path;
    std::int64_t expires_at_ms = 0;
};

inline constexpr std::chrono::seconds kOneShotLifetime{30};
inline constexpr std::string_view kOneShotPrefix = "dm1_";

// The tokens table, with one-shot tokens.
class TokenStore {
public:
    explicit TokenStore(Catalog& catalog) : catalog_(catalog) {}

    // Throws Error{InvalidArgument} for an invalid name, project, sensor or scope. A token that may
    // push for a sensor may do nothing else, because it can be lost with the device.
    CreatedToken create(const NewToken& wanted);
    // Returns the token if it is neither revoked nor expired; otherwise nullopt. Compares the
    // hashes in constant time. Writes once a minute that it was used; a catalog that may not wait
    // throws Error{Unavailable} then.
    std::optional<Token> find(const std::string& secret);
    bool is_valid(const std::string& id);  // checks a token again that was found before
    std::optional<Token> get_valid(const std::string& id);
    std::vector<Token> list();
    void revoke(const std::string& id);  // throws Error{NotFound}
    bool empty();                        // true: no token is valid; sharing links do not count

    // Returns a one-shot token, which is not stored if the owner has no id (authentication is off).
    OneShotToken create_one_shot(const Token& owner,
                                 const std::string& path,
                                 std::chrono::seconds lifetime = kOneShotLifetime);
    // Both return the token that it was made for, if it is not expired and matches: a path opens
    // that path with any query, a path with a query ("/path?a=1") only that one. The second one
    // uses it up: another call returns nullopt.
    std::optional<Token> find_one_shot(const std::string& secret,
                                       const std::string& path,
                                       const std::string& query = "");
    std::optional<Token> redeem_one_shot(const std::string& secret,
                                         const std::string& path,
                                         const std::string& query = "");

private:
    void record_use(const std::string& id, std::int64_t now_ms);

    Catalog& catalog_;
};

// Returns the token if it is neither revoked nor expired; otherwise nullopt.
std::optional<Token> valid_token(soci::session& session,
                                 const std::string& id,
                                 std::int64_t now_ms);
// Uses up a one-shot token and returns the token that it was made for; nullopt if it was used, has
// expired or is for another path.
std::optional<Token> take_one_shot(soci::session& session,
                                   const std::string& secret,
                                   const std::string& path,
                                   const std::string& query,
                                   std::int64_t now_ms);

}  // namespace divemesh::storage
