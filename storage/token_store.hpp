#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "schemas/token.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

struct NewToken {
    std::string name;
    std::string project = "default";
    std::vector<std::string> scopes;
    std::string sensor;                // required by sensor:push and by nothing else
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

class TokenStore {
public:
    explicit TokenStore(Catalog& catalog) : catalog_(catalog) {}

    // Throws Error{InvalidArgument} for a name, project, sensor or scope that is none. A token that
    // may push for a sensor may do nothing else: it is the one that is lost with the device.
    CreatedToken create(const NewToken& wanted);
    // Neither revoked nor expired. The hashes are compared in constant time. That it was used is
    // written once a minute; a catalog that may not wait throws Error{Unavailable} then.
    std::optional<Token> find(const std::string& secret);
    bool is_valid(const std::string& id);  // the same question about a token that was found before
    std::optional<Token> get_valid(const std::string& id);
    std::vector<Token> list();
    void revoke(const std::string& id);  // throws Error{NotFound}
    bool empty();                        // none that is valid

    // An owner without id is nobody: where no tokens are asked for none is stored.
    OneShotToken create_one_shot(const Token& owner,
                                 const std::string& path,
                                 std::chrono::seconds lifetime = kOneShotLifetime);
    // The token on whose behalf it was made; for the first who asks, in time and with its path.
    std::optional<Token> redeem_one_shot(const std::string& secret, const std::string& path);

private:
    void record_use(const std::string& id, std::int64_t now_ms);

    Catalog& catalog_;
};

}  // namespace divemesh::storage
