#pragma once

#include <cstdint>
#include <string>

#include "storage/catalog.hpp"

namespace divemesh::storage {

// What a project ("": all of them) stores. Deleted dives do not count as dives, but their bytes,
// and those of deleted results, count until they expire.
struct ProjectUsage {
    std::int64_t num_dives = 0;
    // Counts archives, truth, results, and open uploads with their announced length.
    std::int64_t stored_bytes = 0;
};

// Read the usage of a project; "" means all projects.
ProjectUsage read_usage(soci::session& session, const std::string& project);
ProjectUsage read_usage(Catalog& catalog, const std::string& project);

// Throws Error{OutOfQuota} if a project may not store `more_bytes`; `max_num_bytes` 0: no limit.
// Call it inside the transaction that adds them, so that of two at the same time the second is
// refused.
void require_bytes_of_quota(soci::session& session,
                            const std::string& project,
                            std::int64_t more_bytes,
                            std::int64_t max_num_bytes);

// Throws Error{OutOfQuota}, with the remedy, if a project may not have another dive. Call it as
// above.
void require_dive_of_quota(soci::session& session,
                           const std::string& project,
                           std::int64_t max_num_dives,
                           const std::string& remedy);

}  // namespace divemesh::storage
