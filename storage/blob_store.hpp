#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "storage/opening.hpp"

namespace divemesh::storage {

// An upload's bytes while they arrive. write() appends in memory or page cache; flush() makes all
// bytes written so far durable and returns the durable size. If it throws, the bytes since the last
// flush are cut off: what a disk has refused once, a later flush would report as durable.
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
    // Returns the descriptor of the open file with these bytes, for sendfile(); -1 if they are not
    // in a local file.
    virtual int descriptor() const { return -1; }
};

// Stores archives and artifacts: a directory (write to temp, fsync, rename, fsync the directory) or
// a bucket of an object store, whose uploads are staged on the server's own disk. Keys are made by
// the program ("dives/<id>/archive"), of [a-z0-9._/-] only, and checked: Error{InvalidArgument}.
// Thread-safe.
class BlobStore {
public:
    virtual ~BlobStore() = default;

    // Opens a staged blob. Under an existing key it continues where the durable bytes end: behind
    // all that are there, or, if the disk refuses them, behind the first `num_durable_bytes`.
    virtual std::unique_ptr<StagedBlob> open_staged(const std::string& key,
                                                    std::int64_t num_durable_bytes = 0) = 0;
    virtual std::int64_t staged_size_bytes(const std::string& key) = 0;  // 0: there is none
    virtual std::unique_ptr<BlobReader> read_staged(const std::string& key) = 0;
    virtual void remove_staged(const std::string& key) = 0;
    // Makes staged bytes a blob, atomically. Does nothing if they have become it before.
    virtual void commit_staged(const std::string& staged_key, const std::string& key) = 0;

    // Stores a file. It is durable when the call returns; readers see all of it or no blob.
    virtual void put_file(const std::string& key, const std::filesystem::path& file) = 0;
    virtual std::unique_ptr<BlobReader> open(const std::string& key) = 0;  // throws NotFound
    // Returns a path on this machine to read the blob from: the blob's own file, or the file
    // `copy`, which is written. A copy must have this hash, if one is given: Error{Unavailable}.
    virtual std::filesystem::path local_copy(const std::string& key,
                                             const std::filesystem::path& copy,
                                             const std::string& sha256 = "") = 0;
    virtual bool exists(const std::string& key) = 0;
    virtual void remove(const std::string& key) = 0;  // does nothing if there is none
    virtual void remove_prefix(const std::string& prefix) = 0;
    // Returns the names directly below a prefix that ends with a slash.
    virtual std::vector<std::string> children(const std::string& prefix) = 0;
    // Ends the transfers over a network that are under way, and begins no more: they throw
    // Error{Unavailable}.
    virtual void stop_transfers() {}
    // Returns the free bytes of the disk that takes the uploads; the largest number where none
    // limits them.
    virtual std::int64_t free_bytes() = 0;

    // The id by which the store belongs to a catalog (storage/data_id.hpp), read anew each time;
    // "": it has none, or is not there.
    virtual std::string data_id() = 0;
    virtual void set_data_id(const std::string& id) = 0;  // durable when it returns
    virtual std::string location() const = 0;             // for messages
};

// Opens `file:///path`, a plain path, or s3://bucket?endpoint=... (s3_location.hpp). A bucket
// stages uploads in the folder `stage`; without one it takes none. Throws Error{InvalidArgument}
// for an unsupported scheme, Error{Unavailable} if there is no store and none may be created.
std::unique_ptr<BlobStore> open_blob_store(const std::string& url,
                                           Opening opening = Opening::CreateIfMissing,
                                           const std::filesystem::path& stage = {});

}  // namespace divemesh::storage
