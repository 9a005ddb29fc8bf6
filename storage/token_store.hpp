#pragma once

#include <optional>
#include <string>
#include <vector>

#include "schemas/token.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

struct CreatedToken {
    Token token;
    std::string secret;  // dm_<64 hex>: shown once, stored as its hash
};

class TokenStore {
public:
    explicit TokenStore(Catalog& catalog) : catalog_(catalog) {}

    CreatedToken create(const std::string& name,
                        const std::string& project,
                        const std::vector<std::string>& scopes);
    std::optional<Token> find(const std::string& secret);  // constant-time compare; not revoked
    std::vector<Token> list();
    void revoke(const std::string& id);  // throws Error{NotFound}
    bool empty();                        // none that is not revoked

private:
    void record_use(const std::string& id, std::int64_t now_ms);

    Catalog& catalog_;
};

}  // namespace divemesh::storage
