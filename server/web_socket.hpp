#pragma once

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstddef>
#include <string>

#include "api/client/stream.hpp"
#include "api/services.hpp"
#include "server/server.hpp"

namespace divemesh::server {

// Without compression: events are small, and images are compressed already.
using WebSocket = boost::beast::websocket::stream<api::client::Stream&, false>;

inline constexpr auto kAwaitErrors = boost::asio::as_tuple(boost::asio::use_awaitable);
inline constexpr std::chrono::seconds kTokenTrusted{1};  // until it is checked again

// Sets timeouts, pings, and the largest message that the client may send.
void set_options(WebSocket& socket, const Timeouts& timeouts, std::size_t max_num_bytes);

// Returns whether the token that opened the socket is still valid; "" means no authentication.
boost::asio::awaitable<bool> is_entitled(std::string token_id, api::Services services);

}  // namespace divemesh::server
