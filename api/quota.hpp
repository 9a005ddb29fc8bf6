#pragma once

#include <string>

#include "api/services.hpp"

namespace divemesh::api {

// Whether a project may have so many bytes more, and another dive. Throws Error{OutOfQuota}, which
// stays until somebody deletes something. Blocks: for the pool.
void require_bytes_of_quota(const Services& services,
                            const std::string& project,
                            std::int64_t more_bytes);
void require_dive_of_quota(const Services& services, const std::string& project);

}  // namespace divemesh::api
