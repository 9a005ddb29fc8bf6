#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "schemas/file_descriptor.hpp"

namespace divemesh::sensor {

// A file that only grows, of records with length and checksum: what a power cut leaves of the last
// one is recognised and cut off, all before it is kept; what is damaged elsewhere is passed over,
// up to kMaxSearchBytes for the next whole record. One writer; read() from any thread.
class SegmentFile {
public:
    static constexpr std::size_t kMaxRecordBytes = std::size_t{1} << 20;
    static constexpr std::int64_t kMaxSearchBytes = std::int64_t{2} << 20;
    static constexpr std::int64_t kHeadBytes = 8;  // before each record: its length and checksum

    using OnRecord = std::function<void(std::int64_t offset, std::string_view payload)>;

    // A new, empty one. Throws Error{OutOfSpace}, or Error{Unavailable} with the system's reason.
    static SegmentFile create(const std::filesystem::path& path);
    // One that is there, from begin to end; also where the disk can only be read. Throws
    // Error{Unavailable} when it cannot be read, Error{BadData} when it is no such file.
    static SegmentFile open(const std::filesystem::path& path, const OnRecord& on_record);

    // Where it is now. Throws as create(); then the file is as it was.
    std::int64_t append(std::string_view payload);
    // Throws Error{BadData} when what is there is not what was written.
    std::string read(std::int64_t offset) const;
    void sync() const;  // throws as create()
    // Somebody removed it: what is written here is gone with the process.
    bool is_removed() const;

    std::int64_t size_bytes() const { return size_bytes_; }
    bool is_damaged() const { return is_damaged_; }  // between its records, when it was opened
    const std::filesystem::path& path() const { return path_; }

private:
    SegmentFile(std::filesystem::path path, int descriptor)
        : path_(std::move(path)), descriptor_(descriptor) {}
    void write_at(std::int64_t offset, std::string_view bytes) const;

    std::filesystem::path path_;
    FileDescriptor descriptor_;
    std::int64_t size_bytes_ = 0;
    bool is_damaged_ = false;
};

}  // namespace divemesh::sensor
