#pragma once

#include <cerrno>
#include <unistd.h>
#include <utility>

namespace divemesh {

// Owns an open file descriptor and closes it. Here because storage, worker, api's client and the
// sensor share no lower folder.
class FileDescriptor {
public:
    FileDescriptor() = default;
    explicit FileDescriptor(int number) : number_(number) {}  // negative: not open
    ~FileDescriptor() {
        const int failure = errno;  // of the call that is being reported
        close();
        errno = failure;
    }
    FileDescriptor(FileDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    FileDescriptor& operator=(FileDescriptor&& other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }

    int get() const { return number_; }
    bool is_open() const { return number_ >= 0; }
    // Closes it now; false and errno where the system could not write what it still held.
    bool close() { return !is_open() || ::close(std::exchange(number_, -1)) == 0; }

private:
    int number_ = -1;
};

}  // namespace divemesh
