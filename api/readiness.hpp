#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace divemesh::storage {
class BlobStore;
class Catalog;
}  // namespace divemesh::storage

namespace divemesh::api {

// Checks whether the server can work: the catalog has this version and accepts a write, the blob
// store accepts a file, and the disk has room. Anybody may ask, so the check runs once a second at
// most. Thread-safe.
class Readiness {
public:
    struct Result {
        std::int64_t free_bytes = 0;
        std::string failure;  // the check that failed, and why; "": ready
    };

    // Blocks: run it in the pool.
    Result check(storage::Catalog& catalog, storage::BlobStore& blobs, std::int64_t min_free_bytes);

private:
    std::mutex mutex_;
    Result last_;
    std::chrono::steady_clock::time_point next_poll_;
};

}  // namespace divemesh::api
