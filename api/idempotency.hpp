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
    // Returns null while another request uses the key. The key is free again when the pointer is
    // destroyed.
    std::shared_ptr<const std::string> enter(const std::string& key);

private:
    std::mutex mutex_;
    std::set<std::string> keys_;
};

// Lets a client repeat a POST whose response it lost
// (draft-ietf-httpapi-idempotency-key-header-07). A request with an Idempotency-Key that succeeded
// before is not done again; its response is sent again, for two days. Refusals are not stored, so
// the same key may be tried again. Responses that show a secret are not stored either; their
// requests take no key. A key belongs to its token. Throws Error{InvalidArgument} for an invalid
// key, Error{Conflict} while the first request is under way, Error{BadData} for another request
// with a used key.
//
// The response is stored after the work is done. Work that must not be done twice even if the
// server dies between the two stores request_key() in its own transaction.
Awaitable<Response> answer_once(Request request, Services services, const Route& route);

// Returns a key for exactly this request of this token; "" without an Idempotency-Key.
std::string request_key(const Request& request);

}  // namespace divemesh::api
