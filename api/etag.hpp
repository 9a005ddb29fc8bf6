#pragma once

#include <string>
#include <string_view>

#include "api/http.hpp"

namespace divemesh::api {

// The strong tag of a representation: of its very bytes.
std::string etag_of(std::string_view body);

// Whether a list of tags (If-None-Match) names `etag`, compared weakly; "*" names every one.
bool matches_etag(std::string_view list, std::string_view etag);

// Throws Error{PreconditionFailed} unless a list of tags (If-Match) names `etag`; "*" names every
// one, weak tags none (RFC 9110, 13.1.1).
void require_listed(std::string_view list, std::string_view etag);

// For a write to what GET shows as `body`. Throws Error{PreconditionRequired} without If-Match,
// Error{PreconditionFailed} when it names another tag.
void require_match(const Request& request, std::string_view body);

// Adds the tag to an answer of GET or HEAD with 200 and turns it into 304 when the client has it.
void add_etag(const Request& request, Response& response);

}  // namespace divemesh::api
