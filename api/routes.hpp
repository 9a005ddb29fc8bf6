#pragma once

#include <span>
#include <string_view>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// How the body flows: plain request and response; plain, with a secret in the response; the handler
// reads the request's body itself; it sends bytes of a blob; or it turns the connection into a
// WebSocket.
enum class RouteKind { Plain, Secret, BodyStream, File, WebSocket };

using Handler = Awaitable<Response> (*)(Request, Services);

// One route of the API.
struct Route {
    RouteKind kind;
    verb method;
    std::string_view path;   // "{name}" matches one segment, "{name...}" the rest
    std::string_view scope;  // "": public
    Handler handler;
};

// Returns every route, in the order of the table.
std::span<const Route> routes();

}  // namespace divemesh::api
