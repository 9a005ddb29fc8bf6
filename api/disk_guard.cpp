#include "api/disk_guard.hpp"

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kWatchEvery = std::size_t{1} << 20;

}  // namespace

void require_room(const Services& services) {
    if (services.blobs.free_bytes() < services.limits.min_free_bytes)
        throw Error(ErrorCode::OutOfSpace,
                    "the server's disk is nearly full: delete dives or ask the administrator");
}

void RoomWatch::wrote(const Services& services, std::size_t num_bytes) {
    num_unwatched_ += num_bytes;
    if (num_unwatched_ < kWatchEvery) return;
    num_unwatched_ = 0;
    if (services.blobs.free_bytes() < services.limits.min_free_bytes)
        throw Error(ErrorCode::OutOfSpace,
                    "the server's disk is nearly full, the bytes received are kept: resume when "
                    "there is space again");
}

}  // namespace divemesh::api
