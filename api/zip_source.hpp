#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "api/body_source.hpp"
#include "storage/blob_store.hpp"

namespace divemesh::api {

// A file of a zip archive: a blob, which is opened when its turn comes.
struct ZippedFile {
    std::string name;
    std::string blob;
    std::int64_t size_bytes = 0;
};

// Makes a zip archive of blobs (zip64 where it has to be) in constant memory. `time_s` is the time
// of all its files. Files that are compressed already are stored as they are. `blobs` must outlive
// it. Reading throws Error if a blob is gone or has another size.
std::unique_ptr<BodySource> zip_source(storage::BlobStore& blobs,
                                       std::vector<ZippedFile> files,
                                       std::int64_t time_s);

}  // namespace divemesh::api
