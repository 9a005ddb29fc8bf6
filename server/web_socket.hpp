#pragma once

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/websocket.hpp>
#include <cstddef>

#include "api/client/stream.hpp"
#include "server/server.hpp"

namespace divemesh::server {

// Without compression: events are small, and images are compressed already.
using WebSocket = boost::beast::websocket::stream<api::client::Stream&, false>;

inline constexpr auto kAwaitErrors = boost::asio::as_tuple(boost::asio::use_awaitable);

// Sets timeouts, pings, and the largest message that the client may send.
void set_options(WebSocket& socket, const Timeouts& timeouts, std::size_t max_num_bytes);

}  // namespace divemesh::server
