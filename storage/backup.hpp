#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// What a backup contains.
struct BackupSummary {
    std::int64_t num_blobs = 0;
    std::int64_t num_bytes = 0;
    std::int64_t num_missing = 0;  // removed for good during the backup
};

// Writes one tar with a snapshot of the catalog and every blob that it names, while the service
// keeps running. Unfinished uploads are left out: their clients send them again. `file` appears
// only when it is complete and durable; only its owner may read it. Throws Error{OutOfSpace},
// Error{Unavailable}.
BackupSummary write_backup(Catalog& catalog, BlobStore& blobs, const std::filesystem::path& file);

// Restores catalog and blobs from a backup. `catalog_file` must not exist; it appears only when
// every blob is there and matches its hash. After an interruption, run it again. Throws
// Error{Conflict} if there is a catalog, Error{BadData} for a file that is damaged or not a
// divemesh backup.
BackupSummary read_backup(const std::filesystem::path& file,
                          const std::filesystem::path& catalog_file,
                          BlobStore& blobs);

}  // namespace divemesh::storage
