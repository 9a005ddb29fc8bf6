#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace divemesh::storage {

// An upload's bytes while they arrive. write() appends in memory or page cache; flush() makes
// everything written so far durable and returns the durable size.
class StagedBlob {
public:
    virtual ~StagedBlob() = default;
    virtual void write(std::span<const char> bytes) = 0;  // throws Error{OutOfSpace}
    virtual std::int64_t flush() = 0;                     // throws Error{OutOfSpace}
    virtual std::int64_t size_bytes() const = 0;
};

// Reads a finished blob by range.
class BlobReader {
public:
    virtual ~BlobReader() = default;
    virtual std::int64_t size_bytes() const = 0;
    virtual std::size_t read_at(std::int64_t offset, std::span<char> buffer) = 0;  // 0 at the end
    // Of the open file whose bytes these are, for sendfile(); -1: they are in none of this machine.
    virtual int descriptor() const { return -1; }
};

// Where archives and artifacts are: a directory (write to temp, fsync, rename, fsync the
// directory); later an S3 bucket. Keys are made by us ("dives/<id>/archive"), of [a-z0-9._/-]
// alone, and checked: Error{InvalidArgument}. Thread-safe.
class BlobStore {
public:
    virtual ~BlobStore() = default;

    // Staging: opened again under the same key it goes on where the durable bytes end.
    virtual std::unique_ptr<StagedBlob> open_staged(const std::string& key) = 0;
    virtual std::int64_t staged_size_bytes(const std::string& key) = 0;  // 0: nothing there
    virtual std::unique_ptr<BlobReader> read_staged(const std::string& key) = 0;
    virtual void remove_staged(const std::string& key) = 0;
    // Makes staged bytes a blob, atomically. Already there under `key`: fine.
    virtual void commit_staged(const std::string& staged_key, const std::string& key) = 0;

    // Durable when it returns; a reader sees all of it or nothing.
    virtual void put_file(const std::string& key, const std::filesystem::path& file) = 0;
    virtual std::unique_ptr<BlobReader> open(const std::string& key) = 0;  // throws NotFound
    // A path on this machine to read the blob from: itself, or fetched into `scratch`.
    virtual std::filesystem::path local_copy(const std::string& key,
                                             const std::filesystem::path& scratch) = 0;
    virtual bool exists(const std::string& key) = 0;
    virtual void remove(const std::string& key) = 0;  // gone already: fine
    virtual void remove_prefix(const std::string& prefix) = 0;
    // Names directly below a prefix that ends with a slash.
    virtual std::vector<std::string> children(const std::string& prefix) = 0;
    virtual std::int64_t free_bytes() = 0;
};

// `file:///path` or a plain path. Throws Error{InvalidArgument} for a scheme we do not speak.
std::unique_ptr<BlobStore> open_blob_store(const std::string& url);

}  // namespace divemesh::storage
