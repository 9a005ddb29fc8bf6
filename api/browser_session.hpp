#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "api/http.hpp"
#include "api/routes.hpp"
#include "api/services.hpp"

// Requests of the web page, which are authenticated by a cookie that its scripts cannot read.
namespace divemesh::api {

inline constexpr std::string_view kSessionPath = "/api/v1/session";
inline constexpr std::chrono::minutes kSignInLifetime{15};  // of a link that signs in once

// Returns the secret of the cookie; nullopt if there is none, or if the request names a token
// itself.
std::optional<std::string> session_secret(const Request& request, const ServiceLimits& limits);

// Returns what a page proves with that it could read an answer of this server: browsers send the
// cookie with requests of other pages too.
std::string csrf_token(const std::string& secret);

// Returns the token of the session. Throws Error{Unauthorized} if it has ended, and
// Error{Forbidden} for a request that changes something without the CSRF token, or one, or a
// WebSocket, of another origin.
Awaitable<Token> find_session_token(Request request,
                                    Services services,
                                    RouteKind kind,
                                    std::string secret);

// Makes a link that signs a browser in, once, with the rights of a token; returns its path with the
// secret behind the '#', which browsers do not send. `token_id` "": the oldest token with the scope
// admin. `who` is noted in the audit. Throws Error{NotFound} without a valid token.
std::string make_sign_in_path(const storage::Catalog& catalog,
                              const std::string& token_id,
                              const std::string& who);

// Sets the cookie; "": removes it.
void set_session_cookie(const Request& request,
                        const ServiceLimits& limits,
                        const std::string& secret,
                        Response& response);

}  // namespace divemesh::api
