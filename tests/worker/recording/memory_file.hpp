#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <sys/mman.h>
#include <unistd.h>

#include "schemas/file_descriptor.hpp"

namespace divemesh {

// A file in memory that has a path, for tests that write thousands of files.
class MemoryFile {
public:
    explicit MemoryFile(std::string_view bytes) : opened_(memfd_create("recording", MFD_CLOEXEC)) {
        if (!opened_.is_open()) throw std::runtime_error("memfd_create");
        const ssize_t done = write(opened_.get(), bytes.data(), bytes.size());
        if (done != static_cast<ssize_t>(bytes.size())) throw std::runtime_error("write");
    }
    std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(opened_.get()); }

private:
    FileDescriptor opened_;
};

}  // namespace divemesh
