#include "worker/base/cache_folder.hpp"

#include <algorithm>
#include <chrono>
#include <fcntl.h>
#include <stdlib.h>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <vector>

#include "schemas/error.hpp"
#include "schemas/file_descriptor.hpp"

namespace divemesh::base {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTemporary = "new.";
constexpr auto kTemporaryFoldersLive = std::chrono::hours(24);

struct Entry {
    fs::path path;
    fs::file_time_type used;
    std::int64_t size_bytes = 0;
    bool linked = false;  // from outside the cache
};

bool is_temporary(const fs::path& path) { return path.filename().string().starts_with(kTemporary); }

// A lock, so that only one process at a time removes entries.
class Lock {
public:
    explicit Lock(const fs::path& cache)
        : file_(::open((cache / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
        held_ = file_.is_open() && ::flock(file_.get(), LOCK_EX) == 0;
    }
    bool held() const { return held_; }

private:
    FileDescriptor file_;
    bool held_ = false;
};

// Throws if another process removes the entry meanwhile.
Entry look_at(const fs::path& path) {
    Entry entry{.path = path, .used = fs::last_write_time(path / kCacheListName)};
    for (const auto& found : fs::recursive_directory_iterator(path)) {
        struct stat file {};
        if (::lstat(found.path().c_str(), &file) != 0 || !S_ISREG(file.st_mode)) continue;
        entry.size_bytes += file.st_size;
        entry.linked = entry.linked || file.st_nlink > 1;
    }
    return entry;
}

// Returns the entries, the least recently used one first. Removes what is no entry, and what killed
// processes have left.
std::vector<Entry> list_entries(const fs::path& cache) {
    std::vector<Entry> entries;
    std::error_code failure;
    for (const auto& found : fs::directory_iterator(cache, failure)) {
        if (!found.is_directory(failure)) continue;
        if (is_temporary(found.path())) {
            const auto age = fs::file_time_type::clock::now() - found.last_write_time(failure);
            if (!failure && age > kTemporaryFoldersLive) fs::remove_all(found.path(), failure);
            continue;
        }
        try {
            entries.push_back(look_at(found.path()));
        } catch (const fs::filesystem_error&) {
            remove_cache_entry(cache, found.path());
        }
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return a.used < b.used;
    });
    return entries;
}

// Returns the free bytes of the disk; `unknown` is set if they are not known.
std::int64_t free_bytes(const fs::path& cache, std::error_code& unknown) {
    return static_cast<std::int64_t>(fs::space(cache, unknown).available);
}

}  // namespace

fs::path make_temporary_entry(const fs::path& cache) {
    std::string name = (cache / (std::string(kTemporary) + "XXXXXX")).string();
    if (::mkdtemp(name.data()) == nullptr)
        throw Error(ErrorCode::Unavailable,
                    "cannot create a folder in the cache " + cache.string());
    return name;
}

// Renames the entry first, so that other processes never find half an entry. On a full disk there
// may be no room for the folder that the rename needs.
void remove_cache_entry(const fs::path& cache, const fs::path& entry) {
    std::error_code failure;
    try {
        const fs::path trash = make_temporary_entry(cache);
        fs::rename(entry, trash / "entry", failure);
        fs::remove_all(trash, failure);
    } catch (const Error&) {
        fs::remove(entry / kCacheListName, failure);  // without it, it is no entry
        fs::remove_all(entry, failure);
    }
}

void limit_cache(const fs::path& cache, std::int64_t max_bytes) {
    const Lock lock(cache);
    if (!lock.held()) return;
    const auto entries = list_entries(cache);
    std::int64_t bytes = 0;
    for (const Entry& entry : entries) bytes += entry.size_bytes;
    for (const Entry& entry : entries) {
        if (bytes <= max_bytes) return;
        remove_cache_entry(cache, entry.path);
        bytes -= entry.size_bytes;
    }
}

void make_room(const fs::path& cache, std::int64_t wanted_free_bytes) {
    std::error_code unknown;
    if (free_bytes(cache, unknown) >= wanted_free_bytes || unknown) return;
    const Lock lock(cache);
    for (const Entry& entry : list_entries(cache)) {
        if (free_bytes(cache, unknown) >= wanted_free_bytes || unknown) return;
        if (!entry.linked) remove_cache_entry(cache, entry.path);
    }
}

std::int64_t reachable_free_bytes(const fs::path& cache) {
    std::error_code unknown;
    std::int64_t bytes = free_bytes(cache, unknown);
    if (unknown) return 0;
    for (const Entry& entry : list_entries(cache))
        if (!entry.linked) bytes += entry.size_bytes;
    return bytes;
}

}  // namespace divemesh::base
