#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "api/client/byte_source.hpp"
#include "api/client/server_address.hpp"

namespace divemesh::api::client {

// A request with its whole body in memory.
struct HttpRequest {
    std::string method;
    std::string target;  // below the server's base path: "/api/v1/dives?state=ready"
    std::vector<std::pair<std::string, std::string>> headers;
    std::string body;
    std::chrono::milliseconds timeout{0};  // for the response to begin, besides the usual stall
};

// A response with its whole body in memory, unless a BodySink took it.
struct HttpResponse {
    int status = 0;
    std::map<std::string, std::string> headers;  // names in lower case
    std::string body;

    std::string header(const std::string& name) const;  // "" if it is missing
};

// A range of a source as the body of a request.
struct BodyRange {
    ByteSource* source = nullptr;
    std::int64_t offset = 0;
    std::int64_t length = 0;
    std::size_t write_bytes = std::size_t{128} << 10;  // handed to the network at a time
    std::function<void(std::int64_t bytes_sent)> on_sent;
};

// Receives a body as it arrives. `on_header` is called first and decides whether to take this
// response; if it returns false, the body goes to HttpResponse::body.
struct BodySink {
    std::function<bool(const HttpResponse& header)> on_header;
    std::function<void(std::span<const char> bytes)> on_bytes;
};

// One connection to a server, kept alive between requests and reopened when it is lost. Calls
// block; a call that moves no byte for `stall` fails. Throws Error{Unavailable} for every network
// failure and Error{Forbidden} for a server that does not prove to be the one of the address. A
// response of any status is a result, not an error. Use it from one thread at a time.
class HttpConnection {
public:
    HttpConnection(ServerAddress server, std::chrono::milliseconds stall);
    ~HttpConnection();
    HttpConnection(HttpConnection&&) noexcept;

    HttpResponse send(const HttpRequest& request);
    HttpResponse send(const HttpRequest& request, const BodyRange& body);
    HttpResponse receive(const HttpRequest& request, const BodySink& sink);

    const ServerAddress& server() const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::api::client
