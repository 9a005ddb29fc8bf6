#pragma once

#include <string>

#include "api/services.hpp"

namespace divemesh::api {

// Check whether a project may store so many more bytes, and another dive. Throw Error{OutOfQuota},
// which lasts until a user deletes something. Block: run them in the pool.
void require_bytes_of_quota(const Services& services,
                            const std::string& project,
                            std::int64_t more_bytes);
void require_dive_of_quota(const Services& services, const std::string& project);

}  // namespace divemesh::api
