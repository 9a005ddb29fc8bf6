#include "worker/runner/disk_room.hpp"

#include <algorithm>
#include <filesystem>
#include <sys/stat.h>

#include "worker/base/cache_folder.hpp"

namespace divemesh::runner {
namespace {

namespace fs = std::filesystem;

std::optional<dev_t> disk_of(const fs::path& folder) {
    struct stat status {};
    if (stat(folder.c_str(), &status) != 0) return std::nullopt;
    return status.st_dev;
}

}  // namespace

std::optional<std::int64_t> DiskRoom::reachable_bytes() const {
    std::error_code unknown;
    const auto space = fs::space(config_.work_folder, unknown);
    if (unknown) return std::nullopt;
    auto bytes = static_cast<std::int64_t>(space.available);
    if (disk_of(config_.work_folder) == disk_of(config_.cache_folder))
        bytes = std::max(bytes, base::reachable_free_bytes(config_.cache_folder));
    return bytes - config_.min_free_bytes;
}

bool DiskRoom::make(std::int64_t bytes) const {
    base::make_room(config_.cache_folder, config_.min_free_bytes + bytes);
    std::error_code unknown;
    const auto space = fs::space(config_.work_folder, unknown);
    return unknown || static_cast<std::int64_t>(space.available) - bytes >= config_.min_free_bytes;
}

}  // namespace divemesh::runner
