#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <vector>

namespace divemesh::fusion {

struct SpillSettings {
    std::filesystem::path folder;   // of the scratch file; empty: all stays in memory
    std::int64_t memory_bytes = 0;  // that may be in memory after trim()
};

// Records that are made one after another and never go, in pieces of a mebibyte. Pieces that were
// not used of late are written to a scratch file and leave memory; who asks for one of their
// records brings them back. The file has no name: it goes with the process. Reading is safe from
// several threads; everything else is for one at a time. Throws Error{OutOfSpace}.
class SpillStore {
public:
    // Where a record is: its piece in the upper half, 16 bytes a unit in the lower.
    using Handle = std::uint32_t;
    static constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

    explicit SpillStore(SpillSettings settings = {}) : settings_(std::move(settings)) {}
    ~SpillStore();
    SpillStore(const SpillStore&) = delete;
    SpillStore& operator=(const SpillStore&) = delete;

    Handle allocate(std::size_t num_bytes);  // of zeros, aligned to 16, at most a piece
    std::byte* write(Handle record);
    const std::byte* read(Handle record) const;
    // Lets go of the least lately used pieces when too many are in memory. No pointer outlives it.
    void trim() const;

    std::int64_t size_bytes() const;  // in memory and on disk
    std::int64_t memory_bytes() const { return num_resident_ * std::int64_t{kChunkBytes}; }

private:
    struct Chunk {
        std::atomic<std::byte*> memory = nullptr;
        std::atomic<std::uint64_t> last_use = 0;
        bool changed = true;  // since it was written to the file
    };

    std::byte* take_memory() const;
    void give_memory(std::byte* memory) const;
    std::byte* resident(std::size_t chunk) const;
    void spill(std::size_t chunk) const;

    SpillSettings settings_;
    // Where a record is kept is not part of its value.
    mutable std::deque<Chunk> chunks_;
    mutable std::mutex loading_;
    // Memory of pieces that were let go, for the next ones: with those in memory never more than
    // were in memory at once.
    mutable std::vector<std::byte*> spare_;
    mutable std::uint64_t now_ = 1;
    mutable std::atomic<std::int64_t> num_resident_ = 0;
    mutable int file_ = -1;
    std::size_t used_bytes_ = kChunkBytes;  // of the last piece
};

}  // namespace divemesh::fusion
