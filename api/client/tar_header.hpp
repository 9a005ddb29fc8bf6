#pragma once

#include <cstdint>
#include <string>

namespace divemesh::api::client {

inline constexpr std::int64_t kTarBlockBytes = 512;

// Returns what precedes a file's bytes in a tar: one ustar block (POSIX.1-1988), and before it a
// pax extended header (POSIX.1-2001) for a name or size that ustar cannot hold. Every file has time
// 0, owner 0 and mode 0644, so that the same files give the same tar anywhere.
std::string tar_header(const std::string& path, std::int64_t size_bytes);

// Returns the number of bytes that pad a file's last block.
constexpr std::int64_t tar_padding_bytes(std::int64_t size_bytes) {
    return (kTarBlockBytes - size_bytes % kTarBlockBytes) % kTarBlockBytes;
}

}  // namespace divemesh::api::client
