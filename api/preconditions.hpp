#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Returns audited() for a change that the client may tie to the version it read. With If-Match its
// transactions throw Error{PreconditionFailed} unless the header names the tag of the resource as
// `shown` reads it then, the same as GET. What has a tag is a JSON object.
storage::Catalog audited_if_match(const Services& services,
                                  const Request& request,
                                  std::function<nlohmann::json()> shown);

// Checks a change of something that has no GET of its own and therefore no tag: If-Match can only
// be "*". Throws Error{PreconditionFailed}.
void require_no_tag(const Request& request);

}  // namespace divemesh::api
