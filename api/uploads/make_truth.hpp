#pragma once

#include <string>

#include "api/services.hpp"
#include "api/uploads/upload_metadata.hpp"
#include "schemas/truth_file.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Makes truth of a complete upload, as make_dive() makes a dive. Safe to repeat after any crash;
// the caller holds the upload lock. Throws as make_dive() does, Error{NotFound} if its dive is
// gone, and Error{Conflict} if the dive is deleted or refused. Blocks as make_dive() does.
TruthFile make_truth(const Services& services,
                     storage::Catalog& catalog,
                     const Upload& upload,
                     const UploadPlan& plan,
                     const std::string& sha256);

// Removes the files of deleted truth. Blocks.
void remove_deleted_truth(const Services& services);

}  // namespace divemesh::api
