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

// Whether the server can do its work: the catalog is of this version and takes a write, the blob
// store takes a file, and there is room on the disk. Anybody may ask, so it is found out once a
// second at most. Thread-safe.
class Readiness {
public:
    struct Result {
        std::int64_t free_bytes = 0;
        std::string failure;  // the check that failed, and why; "": ready
    };

    // Blocks: for the pool.
    Result look(storage::Catalog& catalog, storage::BlobStore& blobs, std::int64_t min_free_bytes);

private:
    std::mutex mutex_;
    Result last_;
    std::chrono::steady_clock::time_point next_poll_;
};

}  // namespace divemesh::api
