#include "worker/base/atomic_file.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "schemas/error.hpp"

namespace divemesh::base {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

[[noreturn]] void fail(const std::filesystem::path& file, int code) {
    const std::string reason = std::generic_category().message(code);
    if (code == ENOSPC || code == EDQUOT || code == EFBIG)
        throw Error(ErrorCode::OutOfSpace,
                    "cannot write " + file.string() + ": " + reason +
                        ": free space there or choose another folder");
    throw Error(ErrorCode::Unavailable, "cannot write " + file.string() + ": " + reason);
}

void sync_folder(const std::filesystem::path& folder) {
    const FileDescriptor opened(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!opened.is_open()) fail(folder, errno);
    if (fsync(opened.get()) != 0 && errno != EINVAL)  // EINVAL: a file system without it
        fail(folder, errno);
}

}  // namespace

template <typename Write>
void AtomicFile::write_all(std::string_view rest, const Write& write_some) {
    while (!rest.empty()) {
        const ssize_t written = write_some(rest);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail(file_, errno);
        rest.remove_prefix(static_cast<std::size_t>(written));
    }
}

AtomicFile::AtomicFile(std::filesystem::path file, Durability durability)
    : file_(std::move(file)),
      partial_(file_.string() + ".partial"),
      durability_(durability),
      opened_(open(partial_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
    if (!opened_.is_open()) fail(file_, errno);
    buffer_.reserve(kBufferBytes);
}

AtomicFile::~AtomicFile() {
    if (opened_.is_open()) unlink(partial_.c_str());
}

void AtomicFile::write(std::string_view bytes) {
    buffer_.append(bytes);
    if (buffer_.size() >= kBufferBytes) flush();
}

void AtomicFile::overwrite(std::uint64_t offset_bytes, std::string_view bytes) {
    flush();
    auto offset = static_cast<off_t>(offset_bytes);
    write_all(bytes, [&](std::string_view rest) {
        const ssize_t written = ::pwrite(opened_.get(), rest.data(), rest.size(), offset);
        offset += std::max<ssize_t>(written, 0);
        return written;
    });
}

void AtomicFile::flush() {
    write_all(buffer_, [&](std::string_view rest) {
        return ::write(opened_.get(), rest.data(), rest.size());
    });
    buffer_.clear();
}

void AtomicFile::commit() {
    flush();
    const bool synced = durability_ == Durability::Synced;
    if (synced && fsync(opened_.get()) != 0) fail(file_, errno);
    if (!opened_.close() || rename(partial_.c_str(), file_.c_str()) != 0) {
        const int code = errno;
        unlink(partial_.c_str());
        fail(file_, code);
    }
    if (synced) sync_folder(file_.has_parent_path() ? file_.parent_path() : ".");
}

void write_file(const std::filesystem::path& file, std::string_view bytes, Durability durability) {
    AtomicFile output(file, durability);
    output.write(bytes);
    output.commit();
}

}  // namespace divemesh::base
