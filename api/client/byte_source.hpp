#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "schemas/file_descriptor.hpp"

namespace divemesh::api::client {

// Bytes of a known length that can be read from any place: what an upload can go on with after it
// was cut.
class ByteSource {
public:
    virtual ~ByteSource() = default;
    virtual std::int64_t size_bytes() const = 0;
    // As many bytes as fit or are left, at least one before the end. Throws Error{Conflict} when
    // the file behind it changed since it was opened.
    virtual std::size_t read_at(std::int64_t offset, std::span<char> buffer) = 0;
};

// Tells whether a file is still what it was.
struct FileStamp {
    std::int64_t size_bytes = 0;
    std::int64_t modified_ns = 0;

    bool operator==(const FileStamp&) const = default;
};

FileStamp stamp_of(const std::filesystem::path& path);  // throws Error{NotFound}

// An open file, closed with the object.
class OpenFile {
public:
    // Throws Error{NotFound} with the system's reason. Does not follow a link at the last name.
    explicit OpenFile(const std::filesystem::path& path);
    // `path` below `folder`: no link is followed on the way, so nothing outside is reached.
    OpenFile(const std::filesystem::path& folder, const std::filesystem::path& path);

    const FileStamp& stamp() const { return stamp_; }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) const;  // 0 at the end

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
