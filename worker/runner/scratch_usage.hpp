#pragma once

#include <cstdint>
#include <filesystem>
#include <sys/types.h>

namespace divemesh::runner {

// Returns the disk usage of an attempt: the files below its folder (those with several hard links
// count in part) and the unlinked files that process `pid` holds open.
std::int64_t scratch_usage_bytes(const std::filesystem::path& folder, pid_t pid);

}  // namespace divemesh::runner
