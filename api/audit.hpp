#pragma once

#include "api/http.hpp"
#include "api/routes.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Whether an answer is of a request that changed something in somebody's name.
bool is_audited(const Request& request, const Response& response);

// Writes who changed what, from where, as an event of the topic audit, which administrators alone
// see. Blocks: for the pool. What cannot be written is logged.
void write_audit(const Services& services, const Request& request, const Response& response);

}  // namespace divemesh::api
