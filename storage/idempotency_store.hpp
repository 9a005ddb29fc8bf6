#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "storage/catalog.hpp"

namespace divemesh::storage {

// The stored response to a request with an Idempotency-Key.
struct StoredAnswer {
    std::string fingerprint;  // SHA-256 of the request
    int status = 0;
    std::string headers;  // JSON: [[name, value], ...]
    std::string body;
};

// The idempotent_answers table. A key belongs to the token that used it. The request keys that
// JobStore::enqueue keeps are forgotten with these responses.
class IdempotencyStore {
public:
    explicit IdempotencyStore(Catalog& catalog) : catalog_(catalog) {}

    std::optional<StoredAnswer> find(const std::string& token_id, const std::string& key);
    void put(const std::string& token_id, const std::string& key, const StoredAnswer& answer);
    void forget(std::int64_t older_than_ms);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
