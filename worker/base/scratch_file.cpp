#include "worker/base/scratch_file.hpp"

#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "schemas/error.hpp"

namespace divemesh::base {
namespace {

[[noreturn]] void fail(const std::filesystem::path& folder, const std::string& what, int code) {
    throw Error(ErrorCode::OutOfSpace,
                "cannot " + what + " a scratch file in " + folder.string() + ": " +
                    std::generic_category().message(code) +
                    ": free space there or choose another folder");
}

}  // namespace

ScratchFile::ScratchFile(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::string name = (folder_ / "scratch-XXXXXX").string();
    opened_ = FileDescriptor(mkostemp(name.data(), O_CLOEXEC));
    if (!opened_.is_open()) fail(folder_, "make", errno);
    unlink(name.c_str());
}

void ScratchFile::append(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(opened_.get(), bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail(folder_, "write", errno);
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
}

std::string ScratchFile::read(std::uint64_t offset, std::size_t num_bytes) const {
    std::string bytes(num_bytes, '\0');
    for (std::size_t done = 0; done < num_bytes;) {
        const ssize_t moved = pread(opened_.get(),
                                    bytes.data() + done,
                                    num_bytes - done,
                                    static_cast<off_t>(offset + done));
        if (moved < 0 && errno == EINTR) continue;
        if (moved <= 0) fail(folder_, "read", moved < 0 ? errno : EIO);
        done += static_cast<std::size_t>(moved);
    }
    return bytes;
}

}  // namespace divemesh::base
