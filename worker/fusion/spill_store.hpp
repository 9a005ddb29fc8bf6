#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <vector>

#include "schemas/file_descriptor.hpp"

namespace divemesh::fusion {

struct SpillSettings {
    std::filesystem::path folder;   // of the scratch file; empty: all stays in memory
    std::int64_t memory_bytes = 0;  // limit after trim()
};

// Stores records that are allocated one after another and never freed, in chunks of 1 MiB. Chunks
// that were not used lately are written to a scratch file and leave memory; access to one of their
// records loads them again. The file is unlinked and ends with the process. Reading is thread-safe,
// all else is for one thread at a time. Throws Error{OutOfSpace}.
class SpillStore {
public:
    // Address of a record: its chunk in the upper half, the offset in units of 16 bytes in the
    // lower.
    using Handle = std::uint32_t;
    static constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

    explicit SpillStore(SpillSettings settings = {}) : settings_(std::move(settings)) {}
    ~SpillStore();
    SpillStore(const SpillStore&) = delete;
    SpillStore& operator=(const SpillStore&) = delete;

    Handle allocate(std::size_t num_bytes);  // zeroed, aligned to 16; at most a chunk
    std::byte* write(Handle record);
    const std::byte* read(Handle record) const;
    // Spills the least recently used chunks if too many are in memory. Invalidates all pointers.
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
    // Where a record is kept is not part of the store's value.
    mutable std::deque<Chunk> chunks_;
    mutable std::mutex loading_;
    // Memory of spilled chunks, to be reused: with the resident chunks never more than were
    // resident at once.
    mutable std::vector<std::byte*> spare_;
    mutable std::uint64_t now_ = 1;
    mutable std::atomic<std::int64_t> num_resident_ = 0;
    mutable FileDescriptor file_;
    std::size_t used_bytes_ = kChunkBytes;  // of the last chunk
};

}  // namespace divemesh::fusion
