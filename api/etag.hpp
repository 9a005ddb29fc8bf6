#pragma once

#include <string>
#include <string_view>

#include "api/http.hpp"

namespace divemesh::api {

// Returns the strong tag of a representation's exact bytes.
std::string etag_of(std::string_view body);

// Returns the tag of the same representation, compressed. Where a tag is compared with `etag`
// below, the two are the same.
std::string gzip_etag(std::string_view etag);

// Returns whether a list of tags (If-None-Match) contains `etag`, compared weakly; "*" contains
// every tag.
bool matches_etag(std::string_view list, std::string_view etag);

// Throws Error{PreconditionFailed} unless a list of tags (If-Match) contains `etag`. "*" contains
// every tag; a weak tag matches no tag (RFC 9110, 13.1.1).
void require_listed(std::string_view list, std::string_view etag);

// Checks a deletion of what GET shows as `body` that must name what it deletes; other changes may
// go without a tag, see audited_if_match(). Throws Error{PreconditionRequired} without If-Match,
// and Error{PreconditionFailed} if it names another tag.
void require_match(const Request& request, std::string_view body);

// Adds the tag to a response with 200 to GET or HEAD, and turns it into 304 if the client has that
// version.
void add_etag(const Request& request, Response& response);

}  // namespace divemesh::api
