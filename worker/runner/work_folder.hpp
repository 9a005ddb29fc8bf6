#pragma once

#include <filesystem>

#include "schemas/file_descriptor.hpp"

namespace divemesh::runner {

// A folder of one worker process inside the common work folder, locked while the process lives and
// removed with it. Construction removes the folders of dead workers.
class WorkFolder {
public:
    explicit WorkFolder(const std::filesystem::path& common);  // throws Error{Unavailable}
    ~WorkFolder();
    WorkFolder(const WorkFolder&) = delete;
    WorkFolder& operator=(const WorkFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
    FileDescriptor lock_;  // closed after the folder is removed
};

}  // namespace divemesh::runner
