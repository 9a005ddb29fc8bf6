#pragma once

#include <cstdint>
#include <filesystem>

// A cache in a folder on this machine that several processes may use. Each entry is a folder with
// the file kCacheListName, whose time is that of its last use. An entry appears and goes by a
// rename, so no process finds half of one.
namespace divemesh::base {

inline constexpr const char* kCacheListName = "files.json";

// Creates a folder for an entry that is being written or removed. Throws Error{Unavailable}.
std::filesystem::path make_temporary_entry(const std::filesystem::path& cache);

// Removes an entry. One that cannot be removed stays.
void remove_cache_entry(const std::filesystem::path& cache, const std::filesystem::path& entry);

// Removes the least recently used entries until the cache has `max_bytes` at most.
void limit_cache(const std::filesystem::path& cache, std::int64_t max_bytes);

// Removes the least recently used entries until the disk of the cache has `wanted_free_bytes` free,
// or no entry is left. Keeps entries whose files are linked from elsewhere: a running attempt uses
// them, and to remove them would free no space. Does nothing if there is no such folder.
void make_room(const std::filesystem::path& cache, std::int64_t wanted_free_bytes);

// Returns the free bytes of the disk that make_room() could reach; 0 if there is no such folder.
std::int64_t reachable_free_bytes(const std::filesystem::path& cache);

}  // namespace divemesh::base
