#include "api/disk_guard.hpp"

#include "schemas/error.hpp"

namespace divemesh::api {

void require_room(const Services& services) {
    if (services.blobs.free_bytes() < services.limits.min_free_bytes)
        throw Error(ErrorCode::OutOfSpace,
                    "the server's disk is nearly full: delete dives or ask its administrator");
}

}  // namespace divemesh::api
