#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

struct BackupSummary {
    std::int64_t num_blobs = 0;
    std::int64_t num_bytes = 0;
    std::int64_t num_missing = 0;  // removed for good while the backup ran
};

// Writes one tar: a snapshot of the catalog and every blob that it names, while everybody goes on
// working. Unfinished uploads are left out: their clients send them again. `file` is there when it
// is whole and durable, for its owner alone to read. Throws Error{OutOfSpace}, Error{Unavailable}.
BackupSummary write_backup(Catalog& catalog, BlobStore& blobs, const std::filesystem::path& file);

// Makes catalog and blobs of a backup. `catalog_file` must not exist, and does only when every blob
// is there and is what its hash says; interrupted, it is simply run again. Throws Error{Conflict}
// when there is a catalog, Error{BadData} for what is no backup of ours or is damaged.
BackupSummary read_backup(const std::filesystem::path& file,
                          const std::filesystem::path& catalog_file,
                          BlobStore& blobs);

}  // namespace divemesh::storage
