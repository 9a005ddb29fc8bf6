#pragma once

#include <memory>
#include <string>

#include "storage/blob_store.hpp"

namespace divemesh::storage {

// Opens a store of blobs as files below `folder`: blobs/ finished blobs, staged/ uploads while they
// arrive, tmp/ files while they are copied in, data-id the id of the data folder. Creates the
// folders if it may; throws Error{Unavailable}.
std::unique_ptr<BlobStore> open_directory_blob_store(const std::string& folder, Opening opening);

}  // namespace divemesh::storage
