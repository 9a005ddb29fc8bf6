#include "worker/recording/input_file.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include "schemas/error.hpp"

namespace divemesh::recording {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, int code) {
    const ErrorCode kind = code == ENOENT ? ErrorCode::NotFound : ErrorCode::Unavailable;
    std::string text = "cannot read " + path.string() + ": ";
    text += std::generic_category().message(code);
    text += ": check the path and the right to read it";
    throw Error(kind, text);
}

}  // namespace

InputFile::InputFile(std::filesystem::path path)
    : path_(std::move(path)), opened_(open(path_.c_str(), O_RDONLY | O_CLOEXEC)) {
    struct stat status {};
    if (!opened_.is_open() || fstat(opened_.get(), &status) != 0) fail(path_, errno);
    if (!S_ISREG(status.st_mode)) fail(path_, S_ISDIR(status.st_mode) ? EISDIR : EINVAL);
    size_bytes_ = status.st_size;
}

std::string InputFile::read(std::int64_t offset_bytes, std::int64_t num_bytes) const {
    const std::int64_t there = std::max<std::int64_t>(size_bytes_ - offset_bytes, 0);
    std::string bytes(static_cast<std::size_t>(std::clamp<std::int64_t>(num_bytes, 0, there)),
                      '\0');
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t got = pread(opened_.get(),
                                  bytes.data() + done,
                                  bytes.size() - done,
                                  offset_bytes + static_cast<std::int64_t>(done));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail(path_, errno);
        if (got == 0) break;  // it was cut since it was opened
        done += static_cast<std::size_t>(got);
    }
    bytes.resize(done);
    return bytes;
}

}  // namespace divemesh::recording
