#pragma once

#include <string>

#include "api/services.hpp"
#include "api/uploads/upload_metadata.hpp"
#include "schemas/truth_file.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Makes truth of a complete upload, as make_dive() makes a dive: safe to repeat after any crash, by
// whoever has the upload's turn. Throws what that throws, Error{NotFound} when its dive is gone and
// Error{Conflict} when it is deleted or refused. Blocks: for the pool.
TruthFile make_truth(const Services& services,
                     storage::Catalog& catalog,
                     const Upload& upload,
                     const UploadPlan& plan,
                     const std::string& sha256);

// Removes what nobody finds any more. Blocks.
void remove_deleted_truth(const Services& services);

}  // namespace divemesh::api
