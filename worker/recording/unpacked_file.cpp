#include "worker/recording/unpacked_file.hpp"

#include <cerrno>
#include <fcntl.h>
#include <memory>
#include <new>
#include <stdlib.h>
#include <string>
#include <string_view>
#include <system_error>
#include <unistd.h>
#include <zstd.h>

#include "schemas/error.hpp"
#include "schemas/file_descriptor.hpp"
#include "worker/recording/unpack.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kStep_bytes = std::int64_t{1} << 20U;  // of packed bytes at a time

[[noreturn]] void fail(const fs::path& path, int code) {
    throw Error(code == ENOSPC ? ErrorCode::OutOfSpace : ErrorCode::Unavailable,
                "cannot decompress to " + path.string() + ": " +
                    std::generic_category().message(code) +
                    ": set TMPDIR to a folder on a disk with room, or decompress the file by zstd "
                    "-d");
}

fs::path new_folder() {
    std::string name = (fs::temp_directory_path() / "divemesh.XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) fail(name, errno);
    return name;
}

void write_all(const FileDescriptor& file, std::string_view bytes, const fs::path& path) {
    while (!bytes.empty()) {
        const ssize_t done = ::write(file.get(), bytes.data(), bytes.size());
        if (done < 0 && errno == EINTR) continue;
        if (done < 0) fail(path, errno);
        bytes.remove_prefix(static_cast<std::size_t>(done));
    }
}

[[noreturn]] void fail_as_bomb(const InputFile& packed) {
    throw Error(ErrorCode::TooLarge,
                packed.path().string() + " of " + std::to_string(packed.size_bytes()) +
                    " bytes unpacks to more than 100 times its size or 512 GiB, like a "
                    "decompression bomb: split the recording");
}

// Decompresses a file to another one. Returns whether it did to the end of a frame.
bool decompress(const InputFile& packed,
                const fs::path& path,
                const base::ProgressCallback& progress) {
    const FileDescriptor file(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    if (!file.is_open()) fail(path, errno);
    const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                       &ZSTD_freeDCtx);
    if (!context) throw std::bad_alloc();
    std::string space(ZSTD_DStreamOutSize(), '\0');
    std::int64_t unpacked_bytes = 0;
    std::size_t hint = 0;
    for (std::int64_t at = 0; at < packed.size_bytes(); at += kStep_bytes) {
        progress({"import", 0.0});
        const std::string bytes = packed.read(at, kStep_bytes);
        ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
        bool is_flushed = false;
        while (in.pos < in.size || !is_flushed) {
            ZSTD_outBuffer out{space.data(), space.size(), 0};
            hint = ZSTD_decompressStream(context.get(), &out, &in);
            if (ZSTD_isError(hint)) return false;
            is_flushed = out.pos < out.size;
            unpacked_bytes += static_cast<std::int64_t>(out.pos);
            if (is_bomb(unpacked_bytes, packed.size_bytes())) fail_as_bomb(packed);
            write_all(file, std::string_view(space).substr(0, out.pos), path);
        }
    }
    return hint == 0;
}

}  // namespace

UnpackedFile::UnpackedFile(const InputFile& packed,
                           dive::FindingLog& findings,
                           const base::ProgressCallback& progress)
    : folder_(new_folder()), path_(folder_ / packed.path().stem()) {
    try {
        if (decompress(packed, path_, progress)) return;
    } catch (...) {
        std::error_code ignored;
        fs::remove_all(folder_, ignored);
        throw;
    }
    findings.warning("recording_cut",
                     packed.path().filename().string(),
                     "the file is cut or damaged: it does not decompress to its end; what is "
                     "before is used",
                     "Copy it again if the original is longer.");
}

UnpackedFile::~UnpackedFile() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
}

}  // namespace divemesh::recording
