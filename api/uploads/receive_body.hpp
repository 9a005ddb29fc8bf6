#pragma once

#include <optional>

#include "api/http.hpp"
#include "api/services.hpp"
#include "api/uploads/upload_checksum.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Appends a request's body to `upload`, whose turn the caller has, and answers the upload as it is
// now on disk and in the catalog; nothing when the checksum says that other bytes came than were
// sent: then the upload is as it was. Without a checksum every byte that came is kept, whatever
// ends the body; with one, all of them or none. Throws Error{TooLarge} for what goes past the
// length, Error{Conflict} when a newer request wants the upload, Error{Unavailable} when the client
// went, fell silent or is too slow, Error{OutOfSpace}.
Awaitable<std::optional<Upload>> receive_body(std::shared_ptr<BodyStream> stream,
                                              Services services,
                                              Upload upload,
                                              std::optional<UploadChecksum> checksum);

}  // namespace divemesh::api
