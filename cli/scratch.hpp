#pragma once

#include <filesystem>

namespace divemesh::cli {

// A new folder for this run under `parent`; the destructor removes it.
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
