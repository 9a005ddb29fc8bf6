#include "api/quota.hpp"

#include "storage/project_usage.hpp"

namespace divemesh::api {

void require_bytes_of_quota(const Services& services,
                            const std::string& project,
                            std::int64_t more_bytes) {
    if (services.limits.max_project_bytes == 0) return;
    services.catalog.read([&](soci::session& session) {
        storage::require_bytes_of_quota(
            session, project, more_bytes, services.limits.max_project_bytes);
    });
}

void require_dive_of_quota(const Services& services, const std::string& project) {
    if (services.limits.max_project_dives == 0) return;
    services.catalog.read([&](soci::session& session) {
        storage::require_dive_of_quota(session,
                                       project,
                                       services.limits.max_project_dives,
                                       "delete some, or ask the administrator");
    });
}

}  // namespace divemesh::api
