#include "worker/dive/pack_file.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <string>

#include "schemas/error.hpp"

namespace divemesh::dive {
namespace {

[[noreturn]] void fail(const std::filesystem::path& folder, int code) {
    const bool full = code == ENOSPC || code == EDQUOT || code == EFBIG;
    throw Error(full ? ErrorCode::OutOfSpace : ErrorCode::Unavailable,
                "cannot unpack the dive in " + folder.string() + ": " + std::strerror(code));
}

}  // namespace

PackFile::PackFile(const std::filesystem::path& folder) : folder_(folder) {
    if (folder.empty()) return;
    std::filesystem::create_directories(folder);
    std::string name = (folder / "dive.pack.XXXXXX").string();
    file_ = FileDescriptor(::mkostemp(name.data(), O_CLOEXEC));
    if (!file_.is_open()) fail(folder_, errno);
    if (::unlink(name.c_str()) != 0) fail(folder_, errno);
}

void PackFile::append(std::span<const char> bytes) {
    if (!file_.is_open()) {
        size_bytes_ += std::ssize(bytes);
        return;
    }
    while (!bytes.empty()) {
        const ssize_t written = ::pwrite(file_.get(), bytes.data(), bytes.size(), size_bytes_);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail(folder_, errno);
        size_bytes_ += written;
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
}

void PackFile::read(std::int64_t offset_bytes, std::span<char> bytes) const {
    while (!bytes.empty()) {
        const ssize_t got = ::pread(file_.get(), bytes.data(), bytes.size(), offset_bytes);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) fail(folder_, got < 0 ? errno : EIO);
        offset_bytes += got;
        bytes = bytes.subspan(static_cast<std::size_t>(got));
    }
}

}  // namespace divemesh::dive
