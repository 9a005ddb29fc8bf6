#pragma once

#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "api/routes.hpp"

namespace divemesh::api {

// The Idempotency-Keys of requests under way. Thread-safe.
class KeysInFlight {
public:
    // Null while another request uses the key. It is free again when the pointer goes.
    std::shared_ptr<const std::string> enter(const std::string& key);

private:
    std::mutex mutex_;
    std::set<std::string> keys_;
};

// Lets a client repeat a POST whose answer it lost (draft-ietf-httpapi-idempotency-key-header-07):
// a request with an Idempotency-Key that succeeded before is not done again, its answer is given
// again, for two days. Refusals are not kept, the same key may try again; nor are answers that show
// a secret, whose requests take no key. A key belongs to its token. Throws Error{InvalidArgument}
// for what is no key, Error{Conflict} while the first request is under way, Error{BadData} for
// another request with a key that was used.
//
// The answer is kept after the work is done. What must not be done twice even when the server dies
// between the two keeps request_key() in its own transaction.
Awaitable<Response> answer_once(Request request, Services services, const Route& route);

// Names this very request of this token; "" when it has no Idempotency-Key.
std::string request_key(const Request& request);

}  // namespace divemesh::api
