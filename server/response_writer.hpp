#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <memory>

#include "api/http.hpp"
#include "api/services.hpp"
#include "server/connection.hpp"

namespace divemesh::server {

struct WriteOptions {
    std::chrono::milliseconds timeout;  // of one part
    bool keep_alive = false;
    bool head = false;    // send only the header, as it would be with the body
    bool chunked = true;  // the client knows chunks: it speaks HTTP/1.1
};

// Writes a response, a blob's bytes in parts. Returns false if the client is gone or too slow.
boost::asio::awaitable<bool> write_response(std::shared_ptr<Connection> connection,
                                            api::Response response,
                                            api::Services services,
                                            WriteOptions options);

}  // namespace divemesh::server
