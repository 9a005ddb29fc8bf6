#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "schemas/file_descriptor.hpp"

// File calls below a folder that is given as a descriptor. They follow no symbolic link on the way,
// so files outside cannot be reached. All throw Error: OutOfSpace, NotFound, Unavailable.
namespace divemesh::storage {

// Throws the Error that fits errno: no space, quota or file size limit -> OutOfSpace.
[[noreturn]] void throw_errno(const std::string& doing);

// Opens a folder by its path. Throws as throw_errno() does.
FileDescriptor open_folder(const std::string& path);

// Opens a folder, which is created and made durable if it is missing. Throws Error{Unavailable}.
FileDescriptor make_folder(const std::filesystem::path& path);

// Returns the folder of all `parts` but the last. A missing folder is created and made durable if
// `make`; otherwise the returned descriptor is not open.
FileDescriptor open_parent(const FileDescriptor& root,
                           const std::vector<std::string>& parts,
                           bool make);

// Returns a descriptor that is not open if there is no such file.
FileDescriptor open_file(const FileDescriptor& folder, const std::string& name, int flags);

// Removes the file of a key below a folder, durably. Does nothing if there is none.
void remove_file(const FileDescriptor& folder, const std::string& key);

void write_all(const FileDescriptor& file, std::span<const char> bytes, const std::string& what);
std::int64_t size_of(const FileDescriptor& file);
std::int64_t free_bytes_of(const FileDescriptor& file_or_folder);  // of its disk
void sync(const FileDescriptor& file_or_folder);

// Starts to write the cached bytes to the disk, so that a later sync() finds little left.
void start_write_back(const FileDescriptor& file);

}  // namespace divemesh::storage
