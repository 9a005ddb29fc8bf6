#include "storage/directory_files.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "schemas/error.hpp"
#include "storage/blob_key.hpp"
#include "storage/fault_point.hpp"

namespace divemesh::storage {
namespace {

constexpr int kFolderFlags = O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;

FileDescriptor step_into(const FileDescriptor& folder, const std::string& name, bool make) {
    FileDescriptor next(openat(folder.get(), name.c_str(), kFolderFlags));
    if (next.is_open() || errno != ENOENT || !make) return next;
    if (mkdirat(folder.get(), name.c_str(), 0770) != 0 && errno != EEXIST)
        throw_errno("making a folder for stored data");
    sync(folder);
    return FileDescriptor(openat(folder.get(), name.c_str(), kFolderFlags));
}

}  // namespace

void throw_errno(const std::string& doing) {
    const int failure = errno;
    const std::string message = doing + ": " + std::strerror(failure);
    switch (failure) {
        case ENOSPC:
        case EDQUOT:
        case EFBIG: throw Error(ErrorCode::OutOfSpace, message + ": free some space and try again");
        case ENOENT: throw Error(ErrorCode::NotFound, message);
        default: throw Error(ErrorCode::Unavailable, message);
    }
}

FileDescriptor open_folder(const std::string& path) {
    FileDescriptor folder(open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!folder.is_open()) throw_errno("opening " + path);
    return folder;
}

FileDescriptor make_folder(const std::filesystem::path& path) {
    std::error_code failure;
    std::filesystem::create_directories(path, failure);
    if (failure)
        throw Error(ErrorCode::Unavailable,
                    "cannot create " + path.string() + ": " + failure.message());
    sync(open_folder(path.parent_path().string()));
    return open_folder(path.string());
}

FileDescriptor open_parent(const FileDescriptor& root,
                           const std::vector<std::string>& parts,
                           bool make) {
    FileDescriptor folder(dup(root.get()));
    for (std::size_t i = 0; i + 1 < parts.size() && folder.is_open(); ++i)
        folder = step_into(folder, parts[i], make);
    if (!folder.is_open() && (make || errno != ENOENT)) throw_errno("opening stored data");
    return folder;
}

FileDescriptor open_file(const FileDescriptor& folder, const std::string& name, int flags) {
    if (!folder.is_open()) return {};
    FileDescriptor file(openat(folder.get(), name.c_str(), flags | O_NOFOLLOW | O_CLOEXEC, 0660));
    if (!file.is_open() && errno != ENOENT) throw_errno("opening stored data " + name);
    return file;
}

void remove_file(const FileDescriptor& folder, const std::string& key) {
    const auto parts = split_key(key);
    const FileDescriptor parent = open_parent(folder, parts, false);
    if (!parent.is_open()) return;
    if (unlinkat(parent.get(), parts.back().c_str(), 0) != 0 && errno != ENOENT)
        throw_errno("removing stored data");
    sync(parent);
}

void write_all(const FileDescriptor& file, std::span<const char> bytes, const std::string& what) {
    while (!bytes.empty()) {
        const auto n = ::write(file.get(), bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) throw_errno("writing " + what);
        bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
}

std::int64_t size_of(const FileDescriptor& file) {
    struct stat status {};
    if (fstat(file.get(), &status) != 0) throw_errno("asking for the size of stored data");
    return status.st_size;
}

std::int64_t free_bytes_of(const FileDescriptor& file_or_folder) {
    struct statvfs status {};
    if (fstatvfs(file_or_folder.get(), &status) != 0) throw_errno("asking for free space");
    return static_cast<std::int64_t>(status.f_bavail) * static_cast<std::int64_t>(status.f_frsize);
}

void sync(const FileDescriptor& file_or_folder) {
    fault_point();
    if (fsync(file_or_folder.get()) != 0) throw_errno("making stored data durable");
}

// Only affects speed: if the kernel cannot do it, sync() does all the work.
void start_write_back(const FileDescriptor& file) {
    sync_file_range(file.get(), 0, 0, SYNC_FILE_RANGE_WRITE);
}

}  // namespace divemesh::storage
