#pragma once

#include <cstdint>
#include <optional>

#include "worker/runner/job_runner.hpp"

namespace divemesh::runner {

// The space for attempts on the disk of the scratch folder, beyond min_free_bytes. The cache of
// stages gives way to it, because what it holds can be computed again.
class DiskRoom {
public:
    explicit DiskRoom(const WorkerConfig& config) : config_(config) {}

    // Returns the free bytes, and those that the cache can give up; nullopt if they are not known.
    std::optional<std::int64_t> reachable_bytes() const;
    // Lets the cache give up space until so many bytes are free. Returns false if they are not.
    bool make(std::int64_t bytes) const;

private:
    const WorkerConfig& config_;
};

}  // namespace divemesh::runner
