#include "worker/fusion/spill_store.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <new>
#include <string>
#include <sys/mman.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "schemas/error.hpp"

namespace divemesh::fusion {
namespace {

constexpr std::size_t kUnitBytes = 16;
constexpr int kUnitBits = 16;
static_assert(SpillStore::kChunkBytes == kUnitBytes << kUnitBits);
constexpr std::size_t kMaxSpare = 64;  // chunks
constexpr double kKeptShare = 0.75;    // after trimming, so that not every trim() spills chunks

std::size_t chunk_of(SpillStore::Handle record) { return record >> kUnitBits; }
std::size_t place_of(SpillStore::Handle record) {
    return (record & ((1U << kUnitBits) - 1)) * kUnitBytes;
}

[[noreturn]] void fail(const std::filesystem::path& folder, const std::string& what, int code) {
    throw Error(
        ErrorCode::OutOfSpace,
        "cannot " + what + " a scratch file in " + folder.string() + ": " +
            std::generic_category().message(code) +
            ": free space there, choose another scratch folder or raise fusion_memory_bytes");
}

FileDescriptor open_unnamed(const std::filesystem::path& folder) {
    std::string name = (folder / "spilled-XXXXXX").string();
    FileDescriptor file(mkostemp(name.data(), O_CLOEXEC));
    if (!file.is_open()) fail(folder, "make", errno);
    unlink(name.c_str());
    return file;
}

// Calls `move` (pread or pwrite) until a whole chunk is transferred.
template <typename Move>
void move_chunk(Move&& move) {
    std::size_t done = 0;
    while (done < SpillStore::kChunkBytes) {
        const ssize_t moved = move(done);
        if (moved < 0 && errno == EINTR) continue;
        if (moved <= 0) throw std::system_error(moved < 0 ? errno : EIO, std::generic_category());
        done += static_cast<std::size_t>(moved);
    }
}

// Maps a chunk instead of allocating it on the heap: small allocations would settle in the gaps
// that chunks leave there, and the heap would grow to several times the size of the chunks.
std::byte* map_chunk() {
    void* memory = mmap(nullptr,
                        SpillStore::kChunkBytes,
                        PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS,
                        -1,
                        0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    return static_cast<std::byte*>(memory);
}

void unmap_chunk(std::byte* memory) {
    if (memory != nullptr) munmap(memory, SpillStore::kChunkBytes);
}

}  // namespace

SpillStore::~SpillStore() {
    for (Chunk& chunk : chunks_) unmap_chunk(chunk.memory.load());
    for (std::byte* memory : spare_) unmap_chunk(memory);
}

std::byte* SpillStore::take_memory() const {
    if (spare_.empty()) return map_chunk();
    std::byte* memory = spare_.back();
    spare_.pop_back();
    return memory;
}

void SpillStore::give_memory(std::byte* memory) const {
    if (spare_.size() < kMaxSpare)
        spare_.push_back(memory);
    else
        unmap_chunk(memory);
}

SpillStore::Handle SpillStore::allocate(std::size_t num_bytes) {
    const std::size_t rounded = (num_bytes + kUnitBytes - 1) / kUnitBytes * kUnitBytes;
    if (used_bytes_ + rounded > kChunkBytes) {
        if (chunks_.size() > 0xffff)
            throw Error(ErrorCode::TooLarge, "the map is larger than 64 GiB: choose larger voxels");
        std::byte* memory = take_memory();
        std::memset(memory, 0, kChunkBytes);
        chunks_.emplace_back().memory = memory;
        ++num_resident_;
        used_bytes_ = 0;
    }
    const auto record =
        static_cast<Handle>(((chunks_.size() - 1) << kUnitBits) | (used_bytes_ / kUnitBytes));
    used_bytes_ += rounded;
    return record;
}

std::byte* SpillStore::write(Handle record) {
    std::byte* memory = resident(chunk_of(record));
    chunks_[chunk_of(record)].changed = true;
    return memory + place_of(record);
}

const std::byte* SpillStore::read(Handle record) const {
    return resident(chunk_of(record)) + place_of(record);
}

std::byte* SpillStore::resident(std::size_t index) const {
    Chunk& chunk = chunks_[index];
    if (chunk.last_use.load(std::memory_order_relaxed) != now_)
        chunk.last_use.store(now_, std::memory_order_relaxed);
    std::byte* memory = chunk.memory.load(std::memory_order_acquire);
    if (memory != nullptr) return memory;
    const std::lock_guard lock(loading_);
    memory = chunk.memory.load(std::memory_order_relaxed);
    if (memory != nullptr) return memory;
    memory = take_memory();
    try {
        move_chunk([&](std::size_t done) {
            return pread(file_.get(),
                         memory + done,
                         kChunkBytes - done,
                         static_cast<off_t>(index * kChunkBytes + done));
        });
    } catch (const std::system_error& error) {
        give_memory(memory);
        fail(settings_.folder, "read", error.code().value());
    }
    chunk.memory.store(memory, std::memory_order_release);
    ++num_resident_;
    return memory;
}

void SpillStore::spill(std::size_t index) const {
    Chunk& chunk = chunks_[index];
    std::byte* memory = chunk.memory.load();
    if (chunk.changed) {
        if (!file_.is_open()) file_ = open_unnamed(settings_.folder);
        try {
            move_chunk([&](std::size_t done) {
                return pwrite(file_.get(),
                              memory + done,
                              kChunkBytes - done,
                              static_cast<off_t>(index * kChunkBytes + done));
            });
        } catch (const std::system_error& error) {
            fail(settings_.folder, "write", error.code().value());
        }
        chunk.changed = false;
    }
    chunk.memory = nullptr;
    give_memory(memory);
    --num_resident_;
}

void SpillStore::trim() const {
    ++now_;
    if (settings_.folder.empty() || memory_bytes() <= settings_.memory_bytes) return;
    std::vector<std::pair<std::uint64_t, std::size_t>> oldest_first;
    for (std::size_t i = 0; i < chunks_.size(); ++i)
        if (chunks_[i].memory.load() != nullptr) oldest_first.emplace_back(chunks_[i].last_use, i);
    std::sort(oldest_first.begin(), oldest_first.end());
    const auto kept =
        static_cast<std::int64_t>(kKeptShare * static_cast<double>(settings_.memory_bytes));
    for (const auto& [last_use, index] : oldest_first) {
        if (memory_bytes() <= kept) break;
        spill(index);
    }
}

std::int64_t SpillStore::size_bytes() const {
    return static_cast<std::int64_t>(chunks_.size() * kChunkBytes);
}

}  // namespace divemesh::fusion
