#include "worker/runner/scratch_usage.hpp"

#include <algorithm>
#include <string>
#include <sys/stat.h>
#include <system_error>

namespace divemesh::runner {
namespace {

namespace fs = std::filesystem;

std::int64_t bytes_of(const struct stat& file) { return std::int64_t{512} * file.st_blocks; }

std::int64_t bytes_below(const fs::path& folder) {
    std::int64_t bytes = 0;
    std::error_code failure;
    for (fs::recursive_directory_iterator entry(folder, failure), end; !failure && entry != end;
         entry.increment(failure)) {
        struct stat file {};
        if (lstat(entry->path().c_str(), &file) == 0 && S_ISREG(file.st_mode))
            bytes += bytes_of(file) /
                     std::max<std::int64_t>(1, static_cast<std::int64_t>(file.st_nlink));
    }
    return bytes;
}

std::int64_t unnamed_bytes(pid_t pid) {
    std::int64_t bytes = 0;
    std::error_code failure;
    for (fs::directory_iterator entry("/proc/" + std::to_string(pid) + "/fd", failure), end;
         !failure && entry != end;
         entry.increment(failure)) {
        struct stat file {};
        if (stat(entry->path().c_str(), &file) == 0 && S_ISREG(file.st_mode) && file.st_nlink == 0)
            bytes += bytes_of(file);
    }
    return bytes;
}

}  // namespace

std::int64_t scratch_usage_bytes(const fs::path& folder, pid_t pid) {
    return bytes_below(folder) + unnamed_bytes(pid);
}

}  // namespace divemesh::runner
