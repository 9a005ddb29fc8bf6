#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "api/routes.hpp"

namespace divemesh::api {

// The route that matches a path, with its parameters.
struct RouteMatch {
    const Route* route = nullptr;  // null: unknown path (methods is empty) or another method
    std::map<std::string, std::string, std::less<>> parameters;  // unescaped
    std::vector<verb> methods;                                   // that the path supports
};

// Finds the route of `path`, which is still escaped. The route of GET serves HEAD where HEAD has no
// route. A parameter is never empty; "{name}" matches no slash, escaped or not.
RouteMatch find_route(verb method, std::string_view path);

// Finds the route, authenticates and authorizes the caller, reads the body of a plain route, runs
// the handler, and turns an exception into an error response.
Awaitable<Response> dispatch(Request request, Services services);

}  // namespace divemesh::api
