#pragma once

#include <string>

#include "api/services.hpp"
#include "api/upload_metadata.hpp"
#include "schemas/dive.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

struct MadeDive {
    Dive dive;
    bool is_new = false;  // false: this upload or the same recording was a dive before
    std::string job_id;   // the reconstruction that `plan` asked for; "": none
};

// Makes a dive of a complete upload: checks its hash, turns the staged bytes into a blob, enters it
// in the catalog. Safe to repeat after any crash. The caller has the upload's turn. Throws
// Error{Conflict} for an upload that is not complete, Error{OutOfQuota}, Error{BadData} for one
// that is not what its sha256 said. The dive is entered by `catalog` (api/audit). Blocks, as long
// as reading the archive takes: for the pool.
MadeDive make_dive(const Services& services,
                   storage::Catalog& catalog,
                   const Upload& upload,
                   const UploadPlan& plan);

// Makes the dives that a server killed between the last byte and the catalog still owes. Failures
// are logged: whoever sends the upload's last request again learns them. Blocks.
void make_owed_dives(const Services& services);

// Where the archive of a dive made of this upload is.
std::string archive_key(const Upload& upload);

}  // namespace divemesh::api
