#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <memory>

#include "api/http.hpp"
#include "api/services.hpp"
#include "server/connection.hpp"

namespace divemesh::server {

struct WriteOptions {
    std::chrono::milliseconds timeout;  // of one piece
    bool keep_alive = false;
    bool head = false;  // the header alone, as the body would have it
};

// Writes an answer, a blob's bytes piece by piece. False: the client is gone or too slow.
boost::asio::awaitable<bool> write_response(std::shared_ptr<Connection> connection,
                                            api::Response response,
                                            api::Services services,
                                            WriteOptions options);

}  // namespace divemesh::server
