#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "api/routes.hpp"

namespace divemesh::api {

struct RouteMatch {
    const Route* route = nullptr;  // null: nothing there (no methods), or not by this method
    std::map<std::string, std::string, std::less<>> parameters;  // unescaped
    std::vector<verb> methods;                                   // what the path would answer
};

// `path` is still escaped. HEAD is served by the route of GET where it has none of its own. A
// parameter is never empty; "{name}" takes no slash, escaped or not.
RouteMatch find_route(verb method, std::string_view path);

// Finds the route, sees who asks and whether they may, reads the body of a plain route, runs the
// handler, and turns what it throws into an error response.
Awaitable<Response> dispatch(Request request, Services services);

}  // namespace divemesh::api
