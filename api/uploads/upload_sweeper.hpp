#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Does one round: ends uploads that received no byte within their lifetime, frees the bytes of
// ended uploads, and forgets an ended upload after a month. Skips an upload that a request works
// on, however old it is. Logs a failure and leaves it for the next round.
Awaitable<void> sweep_uploads(Services services);

}  // namespace divemesh::api
