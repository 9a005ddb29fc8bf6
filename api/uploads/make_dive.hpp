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
    bool is_new = false;  // false: this upload or the same recording was a dive before
    std::string job_id;   // the reconstruction that `plan` asked for; "": none
};

// Set when a newer request wants the upload.
using StopFlag = std::shared_ptr<std::atomic<bool>>;

// SHA-256 of what a complete upload holds, from memory or the disk, there in stretches that leave
// the pool to others; "" for an upload that is no archive yet, or a dive already. The caller has
// the upload's turn. Throws Error{Conflict} when it is stopped, Error{Unavailable} with the server.
Awaitable<std::string> hash_archive(Services services, Upload upload, StopFlag stopped);

// Makes a dive of a complete upload: compares the hash, turns the staged bytes into a blob, enters
// it in the catalog. Safe to repeat after any crash. The caller has the upload's turn. Throws
// Error{Conflict} for an upload that is not complete, Error{OutOfQuota}, Error{BadData} for one
// that is not what its sha256 said, Error{Gone} when the dive was deleted since. The dive is
// entered by `catalog` (api/audit). Blocks: for the pool.
MadeDive make_dive(const Services& services,
                   storage::Catalog& catalog,
                   const Upload& upload,
                   const UploadPlan& plan,
                   const std::string& sha256);

// Throws Error{Conflict} for an upload that is not complete or a part, Error{BadData} for one that
// is empty or not what its sha256 said.
void require_whole(const Upload& upload, const UploadPlan& plan, const std::string& sha256);

// Where the archive of a dive, or the file of truth, made of this upload is.
std::string archive_key(const Upload& upload);

}  // namespace divemesh::api
