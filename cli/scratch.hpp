#pragma once

#include <filesystem>

namespace divemesh::cli {

// A folder of this run's own under `parent`, removed with the object.
class ScratchFolder {
public:
    explicit ScratchFolder(const std::filesystem::path& parent);  // throws Error{OutOfSpace}
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

}  // namespace divemesh::cli
