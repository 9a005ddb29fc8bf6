#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "schemas/dive.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// Removes a dive in two steps. A deleted dive can be restored until it expires. Then housekeeping
// removes its blobs and last its rows, so that a crash in between loses no record of what is still
// to be removed.
class DiveRemoval {
public:
    explicit DiveRemoval(Catalog& catalog) : catalog_(catalog) {}

    // Deletes a dive in one transaction. `check` sees the dive and may throw. Its jobs are
    // cancelled; running ones are asked to stop. A dive that is already deleted expires as planned,
    // or sooner. Throws Error{NotFound}.
    Dive remove(const std::string& id,
                std::chrono::milliseconds keep,
                const std::function<void(const Dive&)>& check);
    // Throws Error{NotFound}; Error{Conflict} if it has expired or was uploaded again meanwhile;
    // Error{OutOfQuota} if its project has as many other dives as it may (0: no limit).
    Dive restore(const std::string& id, std::int64_t max_dives_of_project = 0);

    // Returns deleted and expired dives without a running job, `limit` at most.
    std::vector<Dive> expired(int limit);
    // Returns the prefixes and keys in the blob store that belong to the dive.
    std::vector<std::string> blob_prefixes(const Dive& dive);
    // Removes its rows; call it after its blobs are removed. Returns false, and changes nothing, if
    // one of its jobs was started meanwhile.
    bool forget(const std::string& id);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
