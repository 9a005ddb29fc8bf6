#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "storage/catalog.hpp"

namespace divemesh::storage {

// What a request with an Idempotency-Key was answered with.
struct StoredAnswer {
    std::string fingerprint;  // SHA-256 of the request
    int status = 0;
    std::string headers;  // JSON: [[name, value], ...]
    std::string body;
};

// The idempotent_answers table. A key belongs to the token that used it. What JobStore::enqueue
// keeps of requests is forgotten with their answers.
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
