#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// One round: ends uploads that no byte came for within their lifetime, frees the bytes of those
// that ended, and forgets after a month that they were. An upload that a request works on is left
// alone, however old it is. What fails is logged and left for the next round.
Awaitable<void> sweep_uploads(Services services);

}  // namespace divemesh::api
