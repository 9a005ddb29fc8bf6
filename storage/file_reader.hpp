#pragma once

#include <memory>

#include "schemas/file_descriptor.hpp"
#include "storage/blob_store.hpp"

namespace divemesh::storage {

// Reads an open file.
std::unique_ptr<BlobReader> read_open_file(FileDescriptor file);

}  // namespace divemesh::storage
