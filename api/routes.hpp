#pragma once

#include <span>
#include <string_view>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// How the body flows: plain request and response; plain, with a secret in the response; the handler
// reads the request's body itself; it sends bytes of a blob; it turns the connection into a
// WebSocket; or it sends a file of the web page, which no contract describes.
enum class RouteKind { Plain, Secret, BodyStream, File, WebSocket, Page };

inline constexpr std::string_view kAnyToken = "*";  // in place of a scope

using Handler = Awaitable<Response> (*)(Request, Services);

// One route of the server.
struct Route {
    RouteKind kind;
    verb method;
    std::string_view path;   // "{name}" matches one segment, "{name...}" the rest
    std::string_view scope;  // "": public; kAnyToken
    Handler handler;
};

// Returns every route, in the order of the table.
std::span<const Route> routes();

// Returns the routes that api/openapi.yaml describes: all but those of the web page.
std::span<const Route> api_routes();

}  // namespace divemesh::api
