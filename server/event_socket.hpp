#pragma once

#include <boost/asio/awaitable.hpp>
#include <memory>

#include "api/http.hpp"
#include "server/connection.hpp"
#include "server/request_body.hpp"
#include "server/session_context.hpp"

namespace divemesh::server {

// Answers the request with a WebSocket and sends the events of the feed as they come, a page at a
// time and one frame after the other. So a slow client sets its own pace, and a dead one is dropped
// when it does not answer pings. Ends with code 1001 when the connection is stopped.
boost::asio::awaitable<void> send_events(std::shared_ptr<Connection> connection,
                                         std::shared_ptr<RequestBody> request,
                                         api::EventFeed feed,
                                         SessionContext context);

}  // namespace divemesh::server
