#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "api/http.hpp"
#include "api/services.hpp"
#include "api/uploads/upload_metadata.hpp"
#include "schemas/dive.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

struct MadeDive {
    Dive dive;
    bool is_new = false;  // false: this upload or the same recording already was a dive
    std::string job_id;   // the reconstruction that `plan` requested; "": not requested
};

// Set when a newer request wants the upload.
using StopFlag = std::shared_ptr<std::atomic<bool>>;

// Returns the SHA-256 of a complete upload, from memory or from the disk, which is read in parts so
// that other work in the pool can run. Returns "" for an upload that is not yet an archive, or
// already a dive. The caller holds the upload lock. Throws Error{Conflict} if it is stopped, and
// Error{Unavailable} when the server stops.
Awaitable<std::string> hash_archive(Services services, Upload upload, StopFlag stopped);

// Makes a dive of a complete upload: compares the hash, turns the staged bytes into a blob, enters
// it in the catalog. Safe to repeat after any crash. The caller holds the upload lock. Throws
// Error{Conflict} for an incomplete upload, Error{OutOfQuota}, Error{BadData} for one that differs
// from its stated sha256, Error{Gone} if the dive was deleted since. `catalog` (api/audit) enters
// the dive. Blocks, with an object store for as long as the transfer to it takes: run it in the
// pool for transfers.
MadeDive make_dive(const Services& services,
                   storage::Catalog& catalog,
                   const Upload& upload,
                   const UploadPlan& plan,
                   const std::string& sha256);

// Throws Error{Conflict} for an incomplete upload or a part, and Error{BadData} for an upload that
// is empty or differs from its stated sha256.
void require_whole(const Upload& upload, const UploadPlan& plan, const std::string& sha256);

// Returns the key of the dive archive, or the file of truth, made of this upload.
std::string archive_key(const Upload& upload);

}  // namespace divemesh::api
