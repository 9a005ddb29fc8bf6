#pragma once

#include <cstdint>
#include <list>
#include <mutex>
#include <optional>
#include <string>

#include "schemas/content_hash.hpp"

namespace divemesh::api {

// SHA-256 states over the first bytes of uploads, kept between requests, so that an archive that
// arrives while the server runs is not read again. Bounded; a missing state is computed from the
// disk. Thread-safe.
class HashCache {
public:
    // Takes the state after exactly `offset_bytes` bytes out of the cache; nullopt if it is
    // missing.
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
