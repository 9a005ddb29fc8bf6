#pragma once

#include "api/services.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Enters an upload if the disk and its project's quota have room for it and the project has not too
// many under way. A final upload has the bytes of its parts, which counted, all but those that it
// repeats. Throws
// Error{OutOfSpace}, Error{OutOfQuota}, Error{TooMany}. Blocks.
Upload enter_upload(const Services& services,
                    const Upload& upload,
                    std::int64_t repeated_bytes = 0);

}  // namespace divemesh::api
