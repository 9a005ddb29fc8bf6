#include "storage/file_reader.hpp"

#include <cerrno>
#include <unistd.h>
#include <utility>

#include "storage/directory_files.hpp"

namespace divemesh::storage {
namespace {

class FileReader : public BlobReader {
public:
    explicit FileReader(FileDescriptor file) : file_(std::move(file)) {}

    std::int64_t size_bytes() const override { return size_of(file_); }
    int descriptor() const override { return file_.get(); }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) override {
        for (;;) {
            const auto n = pread(file_.get(), buffer.data(), buffer.size(), offset);
            if (n >= 0) return static_cast<std::size_t>(n);
            if (errno != EINTR) throw_errno("reading stored data");
        }
    }

private:
    FileDescriptor file_;
};

}  // namespace

std::unique_ptr<BlobReader> read_open_file(FileDescriptor file) {
    return std::make_unique<FileReader>(std::move(file));
}

}  // namespace divemesh::storage
