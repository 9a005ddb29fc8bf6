#pragma once

#include <filesystem>
#include <memory>

#include "storage/blob_store.hpp"
#include "storage/s3_client.hpp"

namespace divemesh::storage {

// Opens a store of blobs as objects below the location's prefix: blobs/ finished blobs, data-id the
// id of the data folder. Uploads are staged in the folder `stage` of this machine, which is made;
// without one, the store takes none. The bucket must exist. Throws Error{Unavailable}.
std::unique_ptr<BlobStore> open_s3_blob_store(S3Location location,
                                              S3Credentials credentials,
                                              const std::filesystem::path& stage,
                                              S3Settings settings = {});

}  // namespace divemesh::storage
