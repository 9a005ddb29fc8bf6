#pragma once

#include <cstddef>

#include "api/services.hpp"

namespace divemesh::api {

// Refuses new work before the disk is full, so that reading and deleting still work. Throws
// Error{OutOfSpace}. Blocks: run it in the pool.
void require_room(const Services& services);

// Checks the free space while bytes are written. Many requests may write at once, so each checks
// often.
class RoomWatch {
public:
    // Throws Error{OutOfSpace}; the bytes already written stay.
    void wrote(const Services& services, std::size_t num_bytes);

private:
    std::size_t num_unwatched_ = 0;
};

}  // namespace divemesh::api
