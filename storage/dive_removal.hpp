#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "schemas/dive.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// A dive that goes, in two steps: deleted, it can be brought back until it expires; then whoever
// cleans up removes its blobs and last its rows, so that a crash in between loses nothing of what
// is still to be removed.
class DiveRemoval {
public:
    explicit DiveRemoval(Catalog& catalog) : catalog_(catalog) {}

    // One transaction: `check` sees the dive and may throw; its jobs are cancelled, running ones
    // asked to stop. A dive that is deleted already expires as it would
    // have, or sooner. Throws Error{NotFound}.
    Dive remove(const std::string& id,
                std::chrono::milliseconds keep,
                const std::function<void(const Dive&)>& check);
    // Throws Error{NotFound}, Error{Conflict} when it has expired or was uploaded again meanwhile,
    // Error{OutOfQuota} when its project has as many other dives as it may (0: no limit).
    Dive restore(const std::string& id, std::int64_t max_dives_of_project = 0);

    // Deleted, expired and without a job that runs; at most `limit`.
    std::vector<Dive> expired(int limit);
    // The prefixes and keys in the blob store that are the dive's own.
    std::vector<std::string> blob_prefixes(const Dive& dive);
    // Its rows: after its blobs. False: one of its jobs was begun meanwhile, and nothing is
    // changed.
    bool forget(const std::string& id);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
