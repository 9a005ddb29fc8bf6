#pragma once

#include <cstdint>
#include <string>

#include "storage/catalog.hpp"

namespace divemesh::storage {

// What a project ("": all of them) has here. Deleted dives are no dives any more, but their bytes
// are there until they expire.
struct ProjectUsage {
    std::int64_t num_dives = 0;
    std::int64_t stored_bytes = 0;  // archives, truth, open uploads as long as they said they are
};

ProjectUsage read_usage(soci::session& session, const std::string& project);
ProjectUsage read_usage(Catalog& catalog, const std::string& project);

// Throws Error{OutOfQuota} when a project may not have so many bytes more; `max_num_bytes` 0: no
// limit. Inside the transaction that adds them, so that of two that come at once the second is
// refused.
void require_bytes_of_quota(soci::session& session,
                            const std::string& project,
                            std::int64_t more_bytes,
                            std::int64_t max_num_bytes);

// Throws Error{OutOfQuota} when a project may not have another dive, saying what to do about it.
// As above.
void require_dive_of_quota(soci::session& session,
                           const std::string& project,
                           std::int64_t max_num_dives,
                           const std::string& remedy);

}  // namespace divemesh::storage
