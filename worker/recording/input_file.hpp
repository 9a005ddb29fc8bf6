#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "schemas/file_descriptor.hpp"

namespace divemesh::recording {

// A recording's file, opened for reading at any place. Throws Error{NotFound} if it does not exist,
// Error{Unavailable} with the system's reason if it cannot be read. Reading is thread-safe.
class InputFile {
public:
    explicit InputFile(std::filesystem::path path);

    const std::filesystem::path& path() const { return path_; }
    std::int64_t size_bytes() const { return size_bytes_; }
    // Returns `num_bytes` from a place on, fewer where the file ends. Memory is allocated for bytes
    // that the file has.
    std::string read(std::int64_t offset_bytes, std::int64_t num_bytes) const;

private:
    std::filesystem::path path_;
    FileDescriptor opened_;
    std::int64_t size_bytes_ = 0;
};

}  // namespace divemesh::recording
