#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

namespace divemesh::api {

struct Services;

// Checks whether the server can work: the catalog has this version and accepts a write, the blob
// store accepts a file, and the disk has room. Anybody may ask, so the check runs once a second at
// most. Thread-safe.
class Readiness {
public:
    struct Result {
        std::int64_t free_bytes = 0;
        std::string failure;          // the check that failed, and why; "": ready
        std::string queue_waits_for;  // why no job starts, see WaitReason; "": jobs start
    };

    // Blocks: run it in the pool. While another call asks the stores, returns what the last one
    // found.
    Result check(const Services& services);

private:
    std::optional<Result> last_result();

    std::mutex asking_;  // held while the stores are asked
    std::chrono::steady_clock::time_point next_poll_;
    std::mutex mutex_;
    std::optional<Result> last_;
};

}  // namespace divemesh::api
