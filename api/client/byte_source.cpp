#include "api/client/byte_source.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "schemas/error.hpp"

namespace divemesh::api::client {
namespace {

FileStamp stamp_from(const struct stat& status) {
    return {status.st_size,
            std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec};
}

// Opens a file below `folder`. The descriptor is not open, with the reason in errno, on failure.
FileDescriptor open_below(const std::filesystem::path& folder,
                          const std::filesystem::path& path,
                          Links links) {
    const int flags = O_RDONLY | O_CLOEXEC | (links == Links::Follow ? 0 : O_NOFOLLOW);
    FileDescriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    for (auto part = path.begin(); part != path.end() && opened.is_open(); ++part) {
        const int kind = std::next(part) == path.end() ? O_NONBLOCK : O_DIRECTORY;
        opened = FileDescriptor(::openat(opened.get(), part->c_str(), flags | kind));
    }
    return opened;
}

}  // namespace

FileStamp stamp_of(const std::filesystem::path& path, Links links) {
    struct stat status {};
    const int flags = links == Links::Follow ? 0 : AT_SYMLINK_NOFOLLOW;
    if (::fstatat(AT_FDCWD, path.c_str(), &status, flags) != 0)
        throw Error(ErrorCode::NotFound, "cannot open " + path.string() + ": " + strerror(errno));
    return stamp_from(status);
}

OpenFile::OpenFile(const std::filesystem::path& path)
    : path_(path), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK)) {
    check_kind();
}

OpenFile::OpenFile(const std::filesystem::path& folder,
                   const std::filesystem::path& path,
                   Links links)
    : path_(folder / path), file_(open_below(folder, path, links)) {
    check_kind();
}

void OpenFile::check_kind() {
    if (!file_.is_open())
        throw Error(ErrorCode::NotFound, "cannot open " + path_.string() + ": " + strerror(errno));
    struct stat status {};
    if (::fstat(file_.get(), &status) != 0 || !S_ISREG(status.st_mode))
        throw Error(ErrorCode::InvalidArgument, path_.string() + " is not a regular file");
    stamp_ = stamp_from(status);
}

std::size_t OpenFile::read_at(std::int64_t offset, std::span<char> buffer) const {
    while (true) {
        const ssize_t count = ::pread(file_.get(), buffer.data(), buffer.size(), offset);
        if (count >= 0) return static_cast<std::size_t>(count);
        if (errno != EINTR)
            throw Error(ErrorCode::Unavailable,
                        "cannot read " + path_.string() + ": " + strerror(errno));
    }
}

FileSource::FileSource(const std::filesystem::path& path)
    : path_(std::filesystem::canonical(path)), file_(path_) {}

std::size_t FileSource::read_at(std::int64_t offset, std::span<char> buffer) {
    const std::size_t count = file_.read_at(offset, buffer);
    if (count == 0 && !buffer.empty() && offset < size_bytes())
        throw Error(ErrorCode::Conflict,
                    path_.string() + " became shorter while it was read: start again");
    return count;
}

}  // namespace divemesh::api::client
