#pragma once

#include <cerrno>
#include <unistd.h>
#include <utility>

namespace divemesh {

// Owns an open file descriptor and closes it. It is here because storage, worker, the api's client
// and the sensor share no lower folder.
class FileDescriptor {
public:
    FileDescriptor() = default;
    explicit FileDescriptor(int number) : number_(number) {}  // negative: not open
    ~FileDescriptor() {
        const int failure = errno;  // keeps the errno of a failed call
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
    // Gives the number to the caller, who closes it.
    int release() { return std::exchange(number_, -1); }
    // Closes it now. Returns false with errno if the system could not write the remaining bytes.
    bool close() { return !is_open() || ::close(std::exchange(number_, -1)) == 0; }

private:
    int number_ = -1;
};

}  // namespace divemesh
