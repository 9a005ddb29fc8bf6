#pragma once

#include <optional>

#include "api/http.hpp"
#include "api/services.hpp"
#include "api/uploads/upload_checksum.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Appends a request's body to `upload`, whose lock the caller holds, and returns the upload as it
// is now on disk and in the catalog. Returns nullopt if the checksum does not match: then the
// upload is unchanged. Without a checksum it keeps every byte received, however the body ends; with
// one, all or no bytes. When a newer request wants the upload, it returns what was stored
// until then, and throws Error{Conflict} if that is nothing. Throws Error{TooLarge} beyond the
// length, Error{Unauthorized} when the token is revoked or expires meanwhile, Error{Unavailable} if
// the client disconnected, fell silent or is too slow, Error{OutOfSpace}.
Awaitable<std::optional<Upload>> receive_body(Request request,
                                              Services services,
                                              Upload upload,
                                              std::optional<UploadChecksum> checksum);

}  // namespace divemesh::api
