#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "schemas/file_descriptor.hpp"

// File calls below a folder given as descriptor. No link is followed on the way, so nothing is
// reached outside. All throw Error: OutOfSpace, NotFound, Unavailable.
namespace divemesh::storage {

// Throws the Error that fits errno: no space, quota or file size limit -> OutOfSpace.
[[noreturn]] void throw_errno(const std::string& doing);

FileDescriptor open_folder(const std::string& path);

// The folder that `parts` but the last lead to; one that lacks is made and made durable, or, unless
// `make`, nothing is returned.
FileDescriptor open_parent(const FileDescriptor& root,
                           const std::vector<std::string>& parts,
                           bool make);

// Not open when there is no such file.
FileDescriptor open_file(const FileDescriptor& folder, const std::string& name, int flags);

void write_all(const FileDescriptor& file, std::span<const char> bytes, const std::string& what);
std::int64_t size_of(const FileDescriptor& file);
void sync(const FileDescriptor& file_or_folder);

// Has the disk begin to write what is in memory, so that a later sync() finds little left.
void start_write_back(const FileDescriptor& file);

}  // namespace divemesh::storage
