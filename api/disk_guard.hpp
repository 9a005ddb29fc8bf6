#pragma once

#include "api/services.hpp"

namespace divemesh::api {

// New work is refused before the disk is full, so that reading and deleting go on. Throws
// Error{OutOfSpace}. Blocks: for the pool.
void require_room(const Services& services);

}  // namespace divemesh::api
