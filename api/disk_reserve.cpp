#include "api/disk_reserve.hpp"

#include <fcntl.h>
#include <system_error>

#include "schemas/file_descriptor.hpp"

namespace divemesh::api {
namespace {

namespace fs = std::filesystem;

}  // namespace

void DiskReserve::hold(std::int64_t min_free_bytes) {
    const std::lock_guard lock(mutex_);
    std::error_code failure;
    if (fs::file_size(file_, failure) == static_cast<std::uintmax_t>(kBytes) && !failure) return;
    const auto space = fs::space(file_.parent_path(), failure);
    if (failure || space.available < static_cast<std::uintmax_t>(min_free_bytes + kBytes)) return;
    const FileDescriptor file(
        ::open(file_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (!file.is_open()) return;
    if (::posix_fallocate(file.get(), 0, kBytes) != 0) fs::remove(file_, failure);
}

bool DiskReserve::release() {
    const std::lock_guard lock(mutex_);
    std::error_code failure;
    return fs::remove(file_, failure);
}

}  // namespace divemesh::api
