#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "schemas/file_descriptor.hpp"

namespace divemesh::base {

// A file without a name that ends with the process, for what is too large for memory. Throws
// Error{OutOfSpace} when the disk is full.
class ScratchFile {
public:
    explicit ScratchFile(std::filesystem::path folder);

    void append(std::string_view bytes);
    std::string read(std::uint64_t offset, std::size_t num_bytes) const;

private:
    std::filesystem::path folder_;
    FileDescriptor opened_;
};

}  // namespace divemesh::base
