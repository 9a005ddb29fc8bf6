#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "schemas/share.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

struct NewShare {
    std::string name;
    std::chrono::seconds lifetime = std::chrono::hours(24 * 28);
};

struct CreatedShare {
    Share share;
    std::string secret;  // dms_<32 hex>: shown once, stored as its hash
};

// Sharing links. Each is a row of the tokens table, so TokenStore finds it by its secret and knows
// when it is no longer valid.
class ShareStore {
public:
    explicit ShareStore(Catalog& catalog) : catalog_(catalog) {}

    // Throws Error{InvalidArgument} for an invalid name or lifetime; Error{Conflict} if the job has
    // no result yet, or too many valid links.
    CreatedShare create(const std::string& job_id, const NewShare& wanted);
    std::vector<Share> list(const std::string& job_id);  // oldest first, withdrawn and expired too
    // Throws Error{NotFound} for a link of another job.
    void withdraw(const std::string& job_id, const std::string& share_id);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
