#pragma once

#include <string>
#include <vector>

#include "api/services.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Enters an upload by `catalog` (api/audit) if there is room: on the disk, in its project's quota,
// and among the open uploads of its project and token. A final upload is made of `part_ids`. Throws
// Error{OutOfSpace}, Error{OutOfQuota}, Error{TooMany}. Blocks.
Upload enter_upload(const Services& services,
                    storage::Catalog& catalog,
                    const Upload& upload,
                    const std::vector<std::string>& part_ids = {});

}  // namespace divemesh::api
