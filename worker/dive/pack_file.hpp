#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "schemas/file_descriptor.hpp"

namespace divemesh::dive {

// One append-only file without a name: what was read from an archive lies in it end to end, and it
// is gone with the object, however the process ends. Without a folder it only counts the bytes.
class PackFile {
public:
    explicit PackFile(const std::filesystem::path& folder);

    // Throws Error{OutOfSpace} when the disk is full.
    void append(std::span<const char> bytes);
    std::int64_t size_bytes() const { return size_bytes_; }
    // Fills `bytes` from `offset`; any thread.
    void read(std::int64_t offset_bytes, std::span<char> bytes) const;

private:
    std::filesystem::path folder_;
    FileDescriptor file_;
    std::int64_t size_bytes_ = 0;
};

}  // namespace divemesh::dive
