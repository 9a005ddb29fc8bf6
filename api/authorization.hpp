#pragma once

#include <optional>
#include <string>

#include "api/http.hpp"
#include "api/routes.hpp"
#include "api/services.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {

// Returns the caller's token, found by the bearer token of the request, or by the session of a
// browser. With authentication off every caller is the administrator of the project "default".
// Throws Error{Unauthorized} for a missing or unknown token, and what find_session_token() throws.
// Refuses a token in the URL, because logs and referrers would keep it; only GET of a file or a
// WebSocket may have ?one_shot=. A bearer token that works once is only for signing in.
Awaitable<Token> authenticate(Request request, Services services, RouteKind kind);

// Returns the bearer token of the request if it works once; otherwise nullopt.
std::optional<std::string> bearer_one_shot(const Request& request);

// Returns the error for a one-shot token that is not valid.
Error one_shot_used_up();

// Uses up the one-shot token of a request that has been served, if it came with one; a request that
// is refused leaves it valid. Throws Error{Unauthorized} if another request has used it meanwhile.
Awaitable<void> use_up_one_shot(Request request, Services services);

// Throws Error{Forbidden}, which names the scope, if the token lacks it. Every token has kAnyToken.
void require_scope(const Token& token, const std::string& scope);

// Throws Error{Forbidden} for the token of a sharing link unless the request reads the result of
// the job that it shares.
void require_shared(const Token& token, const Request& request, const Route& route);

// Returns the project whose objects a token sees; "" means all projects (admin).
std::string visible_project(const Token& token);

// Throws Error{NotFound} if the token does not see the object's project, with the same words as for
// an object that does not exist.
void require_visible(const Token& token, const std::string& project, const std::string& what);

// Throws the same error for a sensor that the token may not send reports for.
void require_sensor(const Token& token, const std::string& sensor);

}  // namespace divemesh::api
