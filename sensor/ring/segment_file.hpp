#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "schemas/file_descriptor.hpp"

namespace divemesh::sensor {

// A file that only grows, of records with length and checksum. If a power cut tears the last
// record, it is recognised and cut off, and all records before it are kept. Damage elsewhere is
// skipped, up to kMaxSearchBytes to the next complete record. One writer; read() from any thread.
class SegmentFile {
public:
    static constexpr std::size_t kMaxRecordBytes = std::size_t{1} << 20;
    static constexpr std::int64_t kMaxSearchBytes = std::int64_t{2} << 20;
    static constexpr std::int64_t kHeadBytes = 8;  // before each record: its length and checksum

    using OnRecord = std::function<void(std::int64_t offset, std::string_view payload)>;

    // Creates an empty file. Throws Error{OutOfSpace}, or Error{Unavailable} with the system's
    // reason.
    static SegmentFile create(const std::filesystem::path& path);
    // Opens a file and reads all of it, also on a read-only disk. Throws Error{Unavailable} if it
    // cannot be read, Error{BadData} if it is not a segment.
    static SegmentFile open(const std::filesystem::path& path, const OnRecord& on_record);

    // Returns the offset of the new record. Throws as create() does; then the file is unchanged.
    std::int64_t append(std::string_view payload);
    // Throws Error{BadData} if the bytes are not those that were written.
    std::string read(std::int64_t offset) const;
    void sync() const;  // throws as create() does
    // Returns whether the file was deleted: what is written now is lost with the process.
    bool is_removed() const;

    std::int64_t size_bytes() const { return size_bytes_; }
    bool is_damaged() const { return is_damaged_; }  // between its records, when opened
    const std::filesystem::path& path() const { return path_; }

private:
    SegmentFile(std::filesystem::path path, FileDescriptor descriptor)
        : path_(std::move(path)), descriptor_(std::move(descriptor)) {}
    void write_at(std::int64_t offset, std::string_view bytes) const;

    std::filesystem::path path_;
    FileDescriptor descriptor_;
    std::int64_t size_bytes_ = 0;
    bool is_damaged_ = false;
};

}  // namespace divemesh::sensor
