#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>

namespace divemesh::api {

// Disk space reserved for deleting, because the catalog has to write a deletion down. It is a file
// without content beside the catalog. Thread-safe.
class DiskReserve {
public:
    // Enough for the catalog's log to note the deletion of a hundred dives.
    static constexpr std::int64_t kBytes = std::int64_t{8} << 20;

    explicit DiskReserve(std::filesystem::path file) : file_(std::move(file)) {}

    // Reserves the space unless it is reserved already or less than `min_free_bytes` would be left.
    void hold(std::int64_t min_free_bytes);
    // Releases the space. Returns false if it was not reserved.
    bool release();

private:
    std::mutex mutex_;
    std::filesystem::path file_;
};

}  // namespace divemesh::api
