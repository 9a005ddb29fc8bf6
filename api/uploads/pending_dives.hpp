#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// What became of the dives that were owed.
//
//   Made    none is any more
//   Busy    a request had one of the uploads; it may have been but a question: look again soon
//   Failed  one is still owed
enum class PendingDives { Made, Busy, Failed };

// Makes the dives that are still owed, by a server that was killed between the last byte and the
// catalog or that had no room, beside requests: an upload that one of them has is left to it. The
// token that began the upload has to be valid still. What is not what its sha256 said ends, as if
// it had been terminated; other failures are logged: whoever sends the upload's last request again
// learns them.
Awaitable<PendingDives> make_pending_dives(Services services);

}  // namespace divemesh::api
