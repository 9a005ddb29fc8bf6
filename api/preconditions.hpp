#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// audited(), for a change that the client may bind to what it read: with If-Match its transactions
// throw Error{PreconditionFailed} unless the header names the tag of what GET answers by then,
// which `shown` reads.
storage::Catalog audited_if_match(const Services& services,
                                  const Request& request,
                                  std::function<nlohmann::json()> shown);

// For a change of what no GET answers by itself: it has no tag, so If-Match can be "*" alone.
// Throws Error{PreconditionFailed}.
void require_no_tag(const Request& request);

}  // namespace divemesh::api
