#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// The outcome of a round over the pending dives:
//
//   Made    no dive is pending
//   Busy    a request held one of the upload locks, maybe only for a query: try again soon
//   Failed  a dive is still pending
enum class PendingDives { Made, Busy, Failed };

// Makes the pending dives, in parallel to requests: those of a server that was killed between the
// last byte and the catalog, or that had no room. Skips an upload whose lock a request holds. The
// token that began the upload must still be valid. An upload that differs from its stated sha256
// ends, as if it had been terminated. Other failures are logged; the client learns them when it
// sends the upload's last request again.
Awaitable<PendingDives> make_pending_dives(Services services);

}  // namespace divemesh::api
