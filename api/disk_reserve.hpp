#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>

namespace divemesh::api {

// Room that is kept on the disk for deleting: the catalog has to write down that something is
// gone. A file without content beside the catalog. Thread-safe.
class DiskReserve {
public:
    explicit DiskReserve(std::filesystem::path file) : file_(std::move(file)) {}

    // Takes the room unless it has it, or so little is free that it would be missing elsewhere.
    void hold(std::int64_t min_free_bytes);
    // Gives it up. False: there was none.
    bool release();

private:
    std::mutex mutex_;
    std::filesystem::path file_;
};

}  // namespace divemesh::api
