#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

// File calls below a folder given as descriptor. No link is followed on the way, so nothing is
// reached outside. All throw Error: OutOfSpace, NotFound, Unavailable.
namespace divemesh::storage {

class FileDescriptor {
public:
    FileDescriptor() = default;
    explicit FileDescriptor(int number) : number_(number) {}
    ~FileDescriptor();
    FileDescriptor(FileDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    FileDescriptor& operator=(FileDescriptor&& other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }

    int get() const { return number_; }
    bool is_open() const { return number_ >= 0; }

private:
    int number_ = -1;
};

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
