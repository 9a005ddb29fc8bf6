#pragma once

#include "api/services.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Enters an upload if the disk has room for it and its project has not too many under way. Throws
// Error{OutOfSpace}, Error{TooMany}. Blocks.
Upload enter_upload(const Services& services, const Upload& upload);

}  // namespace divemesh::api
