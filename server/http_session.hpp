#pragma once

#include <boost/asio/awaitable.hpp>
#include <memory>

#include "server/connection.hpp"
#include "server/session_context.hpp"

namespace divemesh::server {

// Reads requests, passes them to api::dispatch and writes the responses, until the client
// disconnects, falls silent or breaks HTTP, or the connection is stopped. Runs on the connection's
// strand.
boost::asio::awaitable<void> run_session(std::shared_ptr<Connection> connection,
                                         SessionContext context);

}  // namespace divemesh::server
