#pragma once

#include <atomic>
#include <memory>

#include "api/http.hpp"
#include "api/services.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Enters the final upload that `wanted` announces: its parts are complete, partial, of the same
// project, and fit together. Asked again for the same parts and metadata it answers the upload of
// the first time. Throws Error{NotFound}, Error{Gone} for a part that is not to be seen,
// Error{InvalidArgument} for one that is no part, Error{Conflict} for one that is not complete,
// Error{TooLarge}, Error{OutOfSpace}, Error{OutOfQuota}. Blocks.
Upload enter_final(const Services& services, storage::Catalog& catalog, Upload wanted);

// Lays the parts' bytes one behind the other, from where a killed server stopped, and frees them.
// Throws Error{Conflict} soon after `stop` was set.
Awaitable<Upload> concatenate(Services services,
                              Upload upload,
                              std::shared_ptr<std::atomic<bool>> stop);

// What the parts hold is part of the final upload now, which is complete: they end, but for those
// that another final upload still needs. Changes nothing when it was done before. Blocks.
void free_parts(const Services& services, const Upload& whole);

}  // namespace divemesh::api
