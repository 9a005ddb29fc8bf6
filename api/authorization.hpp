#pragma once

#include <string>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Who asks, by the bearer token; with authentication off everybody is the administrator of the
// project "default". Throws Error{Unauthorized} without a token that we know, and refuses one in
// the address, where logs and referrers would keep it; there only ?one_shot= may be, for GET of a
// route that takes it.
Awaitable<Token> authenticate(Request request, Services services, bool takes_one_shot);

// Throws Error{Forbidden} that names the scope.
void require_scope(const Token& token, const std::string& scope);

// The project whose objects a token sees; "": all (admin).
std::string visible_project(const Token& token);

// Throws Error{NotFound} for an object of a project that the token does not see, worded as if it
// did not exist.
void require_visible(const Token& token, const std::string& project, const std::string& what);

// The same for a sensor that the token does not push for.
void require_sensor(const Token& token, const std::string& sensor);

}  // namespace divemesh::api
