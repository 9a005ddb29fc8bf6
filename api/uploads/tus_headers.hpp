#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/http.hpp"
#include "api/services.hpp"
#include "schemas/upload.hpp"

// The headers of tus 1.0 (tus.io/protocols/resumable-upload), as they come and as they go.
namespace divemesh::api {

constexpr const char* kTusExtensions =
    "creation,creation-with-upload,creation-defer-length,expiration,checksum,termination,"
    "concatenation";

// 412 with Tus-Version, unless the request names the version that we speak.
std::optional<Response> wrong_version(const Request& request);

// A header that is a number of bytes. Throws Error{InvalidArgument} when it is missing or is not.
std::int64_t count_header(const Request& request, const std::string& name);

// The body is the upload's bytes. Throws Error{Unsupported} for a content coding and for trailers,
// which would have to be undone or read before the bytes are the client's.
bool brings_bytes(const Request& request);
void require_bytes(const Request& request);  // throws Error{Unsupported} when they are not

// What creation announces, checked before anything is stored. Throws Error{InvalidArgument},
// Error{TooLarge}.
Upload announced_upload(const Request& request, const ServiceLimits& limits);

// The ids of "final;URL URL ...", relative or absolute. Throws Error{InvalidArgument} for what is
// no upload's address.
std::vector<std::string> parts_of(const Upload& final_upload);

// Upload-Offset, and Upload-Expires unless it never does.
void set_progress(Response& response, const Upload& upload);

}  // namespace divemesh::api
