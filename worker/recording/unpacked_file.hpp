#pragma once

#include <filesystem>

#include "worker/base/observer.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/recording/input_file.hpp"

namespace divemesh::recording {

// A file that Zstandard compressed as a whole, decompressed in a folder of its own for temporary
// files; the destructor removes it. Of a file that is cut or damaged it is the beginning, with a
// warning. Throws Error{TooLarge} if is_bomb(), Error{OutOfSpace} if the disk has no room.
class UnpackedFile {
public:
    UnpackedFile(const InputFile& packed,
                 dive::FindingLog& findings,
                 const base::ProgressCallback& progress);
    ~UnpackedFile();
    UnpackedFile(const UnpackedFile&) = delete;
    UnpackedFile& operator=(const UnpackedFile&) = delete;

    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path folder_;
    std::filesystem::path path_;  // with the name that the packed file has without .zstd
};

}  // namespace divemesh::recording
