#pragma once

#include <cstdint>
#include <list>
#include <mutex>
#include <optional>
#include <string>

#include "schemas/content_hash.hpp"

namespace divemesh::api {

// SHA-256 of the first bytes of uploads, kept from one request to the next, so that an archive that
// arrives within one life of the server is not read again. Bounded; what is missing is computed
// from the disk. Thread-safe.
class HashCache {
public:
    // The state after exactly `offset_bytes` bytes, which the caller takes over.
    std::optional<Sha256> take(const std::string& upload_id, std::int64_t offset_bytes);
    void put(const std::string& upload_id, std::int64_t offset_bytes, Sha256 hash);
    void forget(const std::string& upload_id);

private:
    struct Entry {
        std::string upload_id;
        std::int64_t offset_bytes;
        Sha256 hash;
    };
    std::mutex mutex_;
    std::list<Entry> entries_;  // newest first
};

}  // namespace divemesh::api
