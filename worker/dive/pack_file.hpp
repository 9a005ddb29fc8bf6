#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "schemas/file_descriptor.hpp"

namespace divemesh::dive {

// An unlinked append-only file that holds the contents of an archive one after another; it is
// deleted with the object, even if the process crashes. Without a folder it only counts the bytes.
class PackFile {
public:
    explicit PackFile(const std::filesystem::path& folder);

    // Throws Error{OutOfSpace} if the disk is full.
    void append(std::span<const char> bytes);
    std::int64_t size_bytes() const { return size_bytes_; }
    // Fills `bytes` from `offset_bytes`. Thread-safe.
    void read(std::int64_t offset_bytes, std::span<char> bytes) const;

private:
    std::filesystem::path folder_;
    FileDescriptor file_;
    std::int64_t size_bytes_ = 0;
};

}  // namespace divemesh::dive
