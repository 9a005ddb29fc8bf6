#include "tests/faults/fault_layer.hpp"

#include <atomic>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <map>
#include <mutex>
#include <new>
#include <sqlite3.h>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace divemesh::faults {
namespace {

std::atomic<bool> armed = false;
std::atomic<bool> has_happened = false;
std::atomic<int> num_left = 0;
Fault fault;  // while `armed`
thread_local bool in_exec = false;
thread_local bool inside = false;  // a call of this layer itself, which counts nothing

bool fails(Call call) {
    if (!armed || inside || call != fault.call) return false;
    const int left = --num_left;
    if (left > 0 || (left < 0 && fault.lasting == Lasting::Once)) return false;
    has_happened = true;
    errno = fault.error;
    return true;
}

template <typename Function>
Function* next(const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

// The sizes of files when they were last made durable.
class DurableSizes {
public:
    void set(int file) {
        struct stat status {};
        if (fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) return;
        const std::lock_guard lock(mutex_);
        sizes_[{status.st_dev, status.st_ino}] = status.st_size;
    }
    // Overwrites what was appended since with zeros: a page that the disk did not take is gone,
    // although the file keeps its size.
    void lose_appended(int file) {
        struct stat status {};
        if (fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) return;
        const std::lock_guard lock(mutex_);
        const auto known = sizes_.find({status.st_dev, status.st_ino});
        off_t from = known == sizes_.end() ? 0 : known->second;
        const int writable =
            ::open(("/proc/self/fd/" + std::to_string(file)).c_str(), O_WRONLY | O_CLOEXEC);
        for (const char zero = 0; writable >= 0 && from < status.st_size; ++from)
            if (::pwrite(writable, &zero, 1, from) != 1) break;
        if (writable >= 0) ::close(writable);
    }

private:
    std::mutex mutex_;
    std::map<std::pair<dev_t, ino_t>, off_t> sizes_;
};

DurableSizes& durable_sizes() {
    static DurableSizes sizes;
    return sizes;
}

// What this layer does itself neither counts nor fails, nor does it change errno.
class Inside {
public:
    Inside() : error_(errno) { std::swap(inside, was_inside_); }
    ~Inside() {
        std::swap(inside, was_inside_);
        errno = error_;
    }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;

private:
    bool was_inside_ = true;
    int error_;
};

template <typename Function>
int sync_by(Function* function, int file) {
    const bool failed = fails(Call::Sync);
    const Inside this_layer;
    if (failed) {
        durable_sizes().lose_appended(file);
        return -1;
    }
    durable_sizes().set(file);
    return function(file);
}

mode_t mode_of(int flags, va_list arguments) {
    return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

void* allocate(std::size_t num_bytes) {
    if (fails(Call::Allocate)) return nullptr;
    return std::malloc(num_bytes == 0 ? 1 : num_bytes);
}

}  // namespace

const char* name_of(Call call) {
    constexpr std::array kNames = {
        "Allocate", "Open", "Read", "Write", "Sync", "Rename", "Remove", "Make", "Statement"};
    return kNames.at(static_cast<std::size_t>(call));
}

void take_as_durable(const std::filesystem::path& folder) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        const int file = ::open(entry.path().c_str(), O_RDONLY | O_CLOEXEC);
        if (file < 0) continue;
        durable_sizes().set(file);
        ::close(file);
    }
}

Armed::Armed(const Fault& wanted) {
    fault = wanted;
    num_left = wanted.number;
    has_happened = false;
    armed = true;
}
Armed::~Armed() { armed = false; }
bool Armed::happened() const { return has_happened; }

}  // namespace divemesh::faults

using divemesh::faults::Call;
using divemesh::faults::fails;
using divemesh::faults::next;

void* operator new(std::size_t num_bytes) {
    void* const memory = divemesh::faults::allocate(num_bytes);
    if (!memory) throw std::bad_alloc();
    return memory;
}
void* operator new[](std::size_t num_bytes) { return operator new(num_bytes); }
void* operator new(std::size_t num_bytes, const std::nothrow_t&) noexcept {
    return divemesh::faults::allocate(num_bytes);
}
void* operator new[](std::size_t num_bytes, const std::nothrow_t&) noexcept {
    return divemesh::faults::allocate(num_bytes);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { std::free(memory); }

extern "C" {

int open(const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = divemesh::faults::mode_of(flags, arguments);
    va_end(arguments);
    static auto* const real = next<int(const char*, int, ...)>("open");
    return fails(Call::Open) ? -1 : real(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = divemesh::faults::mode_of(flags, arguments);
    va_end(arguments);
    static auto* const real = next<int(const char*, int, ...)>("open64");
    return fails(Call::Open) ? -1 : real(path, flags, mode);
}

int openat(int folder, const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = divemesh::faults::mode_of(flags, arguments);
    va_end(arguments);
    static auto* const real = next<int(int, const char*, int, ...)>("openat");
    return fails(Call::Open) ? -1 : real(folder, path, flags, mode);
}

ssize_t read(int file, void* bytes, size_t size) {
    static auto* const real = next<ssize_t(int, void*, size_t)>("read");
    return fails(Call::Read) ? -1 : real(file, bytes, size);
}

ssize_t pread(int file, void* bytes, size_t size, off_t offset) {
    static auto* const real = next<ssize_t(int, void*, size_t, off_t)>("pread");
    return fails(Call::Read) ? -1 : real(file, bytes, size, offset);
}

ssize_t pread64(int file, void* bytes, size_t size, off64_t offset) {
    static auto* const real = next<ssize_t(int, void*, size_t, off64_t)>("pread64");
    return fails(Call::Read) ? -1 : real(file, bytes, size, offset);
}

ssize_t write(int file, const void* bytes, size_t size) {
    static auto* const real = next<ssize_t(int, const void*, size_t)>("write");
    if (!fails(Call::Write)) return real(file, bytes, size);
    const divemesh::faults::Inside this_layer;
    (void)!real(file, bytes, size / 2);
    return -1;
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t offset) {
    static auto* const real = next<ssize_t(int, const void*, size_t, off_t)>("pwrite");
    if (!fails(Call::Write)) return real(file, bytes, size, offset);
    const divemesh::faults::Inside this_layer;
    (void)!real(file, bytes, size / 2, offset);
    return -1;
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t offset) {
    static auto* const real = next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64");
    if (!fails(Call::Write)) return real(file, bytes, size, offset);
    const divemesh::faults::Inside this_layer;
    (void)!real(file, bytes, size / 2, offset);
    return -1;
}

int ftruncate(int file, off_t size) noexcept {
    static auto* const real = next<int(int, off_t)>("ftruncate");
    return fails(Call::Write) ? -1 : real(file, size);
}

int ftruncate64(int file, off64_t size) noexcept {
    static auto* const real = next<int(int, off64_t)>("ftruncate64");
    return fails(Call::Write) ? -1 : real(file, size);
}

int fsync(int file) {
    static auto* const real = next<int(int)>("fsync");
    return divemesh::faults::sync_by(real, file);
}

int fdatasync(int file) {
    static auto* const real = next<int(int)>("fdatasync");
    return divemesh::faults::sync_by(real, file);
}

int rename(const char* from, const char* to) noexcept {
    static auto* const real = next<int(const char*, const char*)>("rename");
    return fails(Call::Rename) ? -1 : real(from, to);
}

int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept {
    static auto* const real = next<int(int, const char*, int, const char*)>("renameat");
    return fails(Call::Rename) ? -1 : real(from_folder, from, to_folder, to);
}

int unlink(const char* path) noexcept {
    static auto* const real = next<int(const char*)>("unlink");
    return fails(Call::Remove) ? -1 : real(path);
}

int unlinkat(int folder, const char* path, int flags) noexcept {
    static auto* const real = next<int(int, const char*, int)>("unlinkat");
    return fails(Call::Remove) ? -1 : real(folder, path, flags);
}

int mkdir(const char* path, mode_t mode) noexcept {
    static auto* const real = next<int(const char*, mode_t)>("mkdir");
    return fails(Call::Make) ? -1 : real(path, mode);
}

int mkdirat(int folder, const char* path, mode_t mode) noexcept {
    static auto* const real = next<int(int, const char*, mode_t)>("mkdirat");
    return fails(Call::Make) ? -1 : real(folder, path, mode);
}

// One statement, whatever the steps in it: it looks at what was finalised, not at what a step says.
int sqlite3_exec(sqlite3* database,
                 const char* sql,
                 int (*row)(void*, int, char**, char**),
                 void* context,
                 char** message) {
    static auto* const real =
        next<int(sqlite3*, const char*, int (*)(void*, int, char**, char**), void*, char**)>(
            "sqlite3_exec");
    if (fails(Call::Statement)) return SQLITE_IOERR;
    divemesh::faults::in_exec = true;
    const int result = real(database, sql, row, context, message);
    divemesh::faults::in_exec = false;
    return result;
}

int sqlite3_step(sqlite3_stmt* statement) {
    static auto* const real = next<int(sqlite3_stmt*)>("sqlite3_step");
    if (!divemesh::faults::in_exec && fails(Call::Statement)) return SQLITE_IOERR;
    return real(statement);
}

}  // extern "C"
