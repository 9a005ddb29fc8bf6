#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/http.hpp"
#include "api/services.hpp"
#include "schemas/upload.hpp"

// The request and response headers of tus 1.0 (tus.io/protocols/resumable-upload).
namespace divemesh::api {

constexpr const char* kTusExtensions =
    "creation,creation-with-upload,creation-defer-length,expiration,checksum,termination,"
    "concatenation";

// Returns 412 with Tus-Version; nullopt if the request names the supported version.
std::optional<Response> wrong_version(const Request& request);

// Returns a header that is a number of bytes. Throws Error{InvalidArgument} if it is missing or not
// a number.
std::int64_t count_header(const Request& request, const std::string& name);

// Returns whether the body is the upload's bytes. Throws Error{Unsupported} for announced trailers,
// which the server would have to read first.
bool brings_bytes(const Request& request);
void require_bytes(const Request& request);  // throws Error{Unsupported} if they are not

// Returns the upload that a creation request announces, checked before anything is stored. Throws
// Error{InvalidArgument}, Error{TooLarge}.
Upload announced_upload(const Request& request, const ServiceLimits& limits);

// Returns the ids of "final;URL URL ...", relative or absolute. Throws Error{InvalidArgument} for a
// URL that is not an upload's.
std::vector<std::string> parts_of(const Upload& final_upload);

// Sets Upload-Offset, and Upload-Expires if the upload expires.
void set_progress(Response& response, const Upload& upload);

}  // namespace divemesh::api
