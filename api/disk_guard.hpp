#pragma once

#include <cstddef>

#include "api/services.hpp"

namespace divemesh::api {

// New work is refused before the disk is full, so that reading and deleting go on. Throws
// Error{OutOfSpace}. Blocks: for the pool.
void require_room(const Services& services);

// The same while bytes are written: many may write at once, so that each looks often.
class RoomWatch {
public:
    // Throws Error{OutOfSpace}; what was written stays.
    void wrote(const Services& services, std::size_t num_bytes);

private:
    std::size_t num_unwatched_ = 0;
};

}  // namespace divemesh::api
