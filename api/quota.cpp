#include "api/quota.hpp"

#include "schemas/error.hpp"
#include "storage/project_usage.hpp"

namespace divemesh::api {

void require_bytes_of_quota(const Services& services,
                            const std::string& project,
                            std::int64_t more_bytes) {
    const std::int64_t most = services.limits.max_project_bytes;
    if (most == 0) return;
    const std::int64_t stored = storage::read_usage(services.catalog, project).stored_bytes;
    if (stored > most || more_bytes > most - stored)
        throw Error(ErrorCode::OutOfQuota,
                    "project " + project + " has " + std::to_string(stored) + " of " +
                        std::to_string(most) + " bytes, " + std::to_string(more_bytes) +
                        " more are too many: delete dives or uploads (the bytes of a deleted dive "
                        "count until it expires), or ask the server's administrator");
}

void require_dive_of_quota(const Services& services, const std::string& project) {
    const std::int64_t most = services.limits.max_project_dives;
    if (most == 0 || storage::read_usage(services.catalog, project).num_dives < most) return;
    throw Error(ErrorCode::OutOfQuota,
                "project " + project + " has " + std::to_string(most) +
                    " dives and may have no more: delete some, or ask the server's administrator");
}

}  // namespace divemesh::api
