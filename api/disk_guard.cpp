#include "api/disk_guard.hpp"

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kWatchEvery = std::size_t{1} << 20;

}  // namespace

std::int64_t reachable_bytes(const Services& services, std::int64_t wanted_bytes) {
    const std::int64_t bytes = services.blobs.free_bytes();
    if (bytes >= wanted_bytes || !services.make_room) return bytes;
    services.make_room(wanted_bytes);
    return services.blobs.free_bytes();
}

bool has_room(const Services& services) {
    const std::int64_t wanted_bytes = services.limits.min_free_bytes;
    return reachable_bytes(services, wanted_bytes) >= wanted_bytes;
}

void require_room(const Services& services) {
    if (!has_room(services))
        throw Error(ErrorCode::OutOfSpace,
                    "the server's disk is nearly full: delete dives or results, or ask the "
                    "administrator");
}

void RoomWatch::wrote(const Services& services, std::size_t num_bytes) {
    num_unwatched_ += num_bytes;
    if (num_unwatched_ < kWatchEvery) return;
    num_unwatched_ = 0;
    if (!has_room(services))
        throw Error(ErrorCode::OutOfSpace,
                    "the server's disk is nearly full, the bytes received are kept: resume when "
                    "there is space again");
}

}  // namespace divemesh::api
