#include "api/web_socket.hpp"

#include <boost/beast/core/string.hpp>

#include "api/error_response.hpp"

namespace divemesh::api {

std::optional<Response> web_socket_refusal(const Request& request) {
    if (boost::beast::iequals(request.header("upgrade"), "websocket")) return std::nullopt;
    Response response = problem_response(request,
                                         http::status::upgrade_required,
                                         "this address is a WebSocket: send an upgrade request");
    response.set("Upgrade", "websocket");
    return response;
}

}  // namespace divemesh::api
