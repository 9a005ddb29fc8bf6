#pragma once

#include <memory>

#include "storage/blob_store.hpp"
#include "storage/s3_client.hpp"

namespace divemesh::storage {

// Reads an object by ranges, ahead of one who reads on: little at first, then up to 2 MiB at a
// time. `client` must outlive it. Throws Error{Unavailable} when the object has been replaced.
std::unique_ptr<BlobReader> read_object(S3Client& client, const std::string& key, S3Object object);

}  // namespace divemesh::storage
