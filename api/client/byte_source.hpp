#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "schemas/file_descriptor.hpp"
#include "schemas/links.hpp"

namespace divemesh::api::client {

// Bytes of a known length that can be read at any offset, so that an interrupted upload can resume.
class ByteSource {
public:
    virtual ~ByteSource() = default;
    virtual std::int64_t size_bytes() const = 0;
    // Reads as many bytes as fit or are left, and returns their number: at least one before the
    // end. Throws Error{Conflict} if the file behind it has changed since it was opened.
    virtual std::size_t read_at(std::int64_t offset, std::span<char> buffer) = 0;
};

// Size and modification time of a file: tells whether it has changed.
struct FileStamp {
    std::int64_t size_bytes = 0;
    std::int64_t modified_ns = 0;

    bool operator==(const FileStamp&) const = default;
};

// Returns the stamp of a file, or of that which a link leads to. Throws Error{NotFound}.
FileStamp stamp_of(const std::filesystem::path& path, Links links = Links::LeaveOut);

// An open file, closed with the object.
class OpenFile {
public:
    // Throws Error{NotFound} with the system's reason. Does not follow a symbolic link as the last
    // component of the path.
    explicit OpenFile(const std::filesystem::path& path);
    // Opens `path` below `folder`. With Links::LeaveOut it follows no symbolic link on the way, so
    // files outside cannot be reached.
    OpenFile(const std::filesystem::path& folder, const std::filesystem::path& path, Links links);

    const FileStamp& stamp() const { return stamp_; }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) const;  // returns 0 at the end

private:
    void check_kind();

    std::filesystem::path path_;
    FileDescriptor file_;
    FileStamp stamp_;
};

// A file as it is, e.g. an archive.
class FileSource : public ByteSource {
public:
    explicit FileSource(const std::filesystem::path& path);
    std::int64_t size_bytes() const override { return file_.stamp().size_bytes; }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) override;

private:
    std::filesystem::path path_;
    OpenFile file_;
};

}  // namespace divemesh::api::client
