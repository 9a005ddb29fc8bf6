#include "storage/upload_stage.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <utility>

#include "schemas/error.hpp"
#include "storage/blob_key.hpp"
#include "storage/directory_files.hpp"
#include "storage/file_reader.hpp"

namespace divemesh::storage {
namespace {

constexpr std::int64_t kWriteBackBytes = 8 << 20;

class StagedFile : public StagedBlob {
public:
    // Bytes that a killed server wrote may not have reached the disk; this makes them durable.
    StagedFile(FileDescriptor file, std::int64_t num_durable_bytes)
        : file_(std::move(file)), num_durable_bytes_(num_durable_bytes) {
        flush();
        if (lseek(file_.get(), 0, SEEK_END) < 0) throw_errno("opening staged data");
    }

    void write(std::span<const char> bytes) override {
        write_all(file_, bytes, "an upload");
        num_new_bytes_ += static_cast<std::int64_t>(bytes.size());
        if (num_new_bytes_ < kWriteBackBytes) return;
        start_write_back(file_);
        num_new_bytes_ = 0;
    }
    std::int64_t flush() override {
        if (is_broken_)
            throw Error(ErrorCode::Unavailable, "the disk has refused this upload: try again");
        try {
            sync(file_);
        } catch (const Error&) {
            // The kernel has dropped the bytes, and would call the next fsync() a success.
            is_broken_ = true;
            cut_off(num_durable_bytes_);
            is_broken_ = false;
            throw;
        }
        return num_durable_bytes_ = size_bytes();
    }
    std::int64_t size_bytes() const override { return size_of(file_); }

private:
    void cut_off(std::int64_t size) const {
        if (size >= size_bytes()) return;
        if (ftruncate(file_.get(), size) != 0 || lseek(file_.get(), size, SEEK_SET) < 0)
            throw_errno("cutting off what the disk did not take");
    }

    FileDescriptor file_;
    std::int64_t num_durable_bytes_;
    bool is_broken_ = false;          // bytes behind the durable ones could not be cut off
    std::int64_t num_new_bytes_ = 0;  // not yet started to write to the disk
};

}  // namespace

std::unique_ptr<StagedBlob> UploadStage::open(const std::string& key,
                                              std::int64_t num_durable_bytes) const {
    const auto parts = split_key(key);
    const FileDescriptor parent = open_parent(folder_, parts, true);
    FileDescriptor file = open_file(parent, parts.back(), O_RDWR | O_CREAT);
    sync(parent);
    return std::make_unique<StagedFile>(std::move(file), num_durable_bytes);
}

std::int64_t UploadStage::size_bytes(const std::string& key) const {
    const FileDescriptor file = find(key);
    return file.is_open() ? size_of(file) : 0;
}

std::unique_ptr<BlobReader> UploadStage::read(const std::string& key) const {
    FileDescriptor file = find(key);
    if (!file.is_open()) throw Error(ErrorCode::NotFound, "no stored data " + key);
    return read_open_file(std::move(file));
}

void UploadStage::remove(const std::string& key) const { remove_file(folder_, key); }

FileDescriptor UploadStage::finished(const std::string& key) const {
    FileDescriptor file = find(key);
    if (file.is_open()) sync(file);
    return file;
}

FileDescriptor UploadStage::find(const std::string& key) const {
    const auto parts = split_key(key);
    return open_file(open_parent(folder_, parts, false), parts.back(), O_RDONLY);
}

}  // namespace divemesh::storage
