#pragma once

#include <cstddef>
#include <cstdint>

#include "api/services.hpp"

namespace divemesh::api {

// Returns the free bytes of the disk. If there are fewer than `wanted_bytes`, what can be computed
// again is given up first. Blocks.
std::int64_t reachable_bytes(const Services& services, std::int64_t wanted_bytes);

// Returns whether new work may begin. Blocks.
bool has_room(const Services& services);

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
