#pragma once

#include <atomic>
#include <memory>

#include "api/http.hpp"
#include "api/services.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Enters the final upload that `wanted` announces. Its parts must be complete, partial, of the same
// project, and fit together. For the same parts and metadata again it returns the first upload.
// Throws Error{NotFound} and Error{Gone} for a part that cannot be seen, Error{InvalidArgument} for
// an upload that is not a part, Error{Conflict} for an incomplete part, Error{TooLarge},
// Error{OutOfSpace}, Error{OutOfQuota}. Blocks.
Upload enter_final(const Services& services, storage::Catalog& catalog, Upload wanted);

// Concatenates the bytes of the parts, from where a killed server stopped, and frees the parts.
// Throws Error{Conflict} soon after `stop` was set.
Awaitable<Upload> concatenate(Services services,
                              Upload upload,
                              std::shared_ptr<std::atomic<bool>> stop);

// Ends the parts of a final upload, which is complete and now has their bytes, except parts that
// another final upload still needs. Safe to repeat. Blocks.
void free_parts(const Services& services, const Upload& whole);

}  // namespace divemesh::api
