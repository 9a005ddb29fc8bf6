#pragma once

#include <cstdint>
#include <filesystem>
#include <sys/types.h>

namespace divemesh::runner {

// What an attempt takes of the disk: the files below its folder (those that have other names
// elsewhere in parts) and those that process `pid` holds open without a name.
std::int64_t scratch_usage_bytes(const std::filesystem::path& folder, pid_t pid);

}  // namespace divemesh::runner
