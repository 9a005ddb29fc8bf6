#pragma once

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>

#include "api/client/stream.hpp"
#include "server/connection.hpp"
#include "server/server.hpp"

namespace divemesh::server {

// Without compression: events are small, and images are compressed already.
using WebSocket = boost::beast::websocket::stream<api::client::Stream&, false>;
using CloseReason = boost::beast::websocket::close_reason;

inline constexpr auto kAwaitErrors = boost::asio::as_tuple(boost::asio::use_awaitable);

// Codes of this service, named after the HTTP status of the same meaning (RFC 6455, 7.4.2).
inline constexpr boost::beast::websocket::close_code kSilent{4408};
inline constexpr boost::beast::websocket::close_code kReplaced{4409};

// Return why a WebSocket is closed: the code, and what the client can show and do.
CloseReason server_stops();
CloseReason token_has_ended();

// The server's end of a WebSocket. All of it runs on the connection's strand.
class ClientSocket {
public:
    explicit ClientSocket(std::shared_ptr<Connection> below);
    virtual ~ClientSocket() = default;
    ClientSocket(const ClientSocket&) = delete;
    ClientSocket& operator=(const ClientSocket&) = delete;

    // Sets timeouts and pings. Call it before the handshake.
    void set_timeouts(const Timeouts& timeouts);
    // Has the stream end; the first reason counts.
    void close(const CloseReason& why);

    std::shared_ptr<Connection> connection;
    WebSocket socket;
    boost::asio::steady_timer silence;  // runs out when the client gives no sign of life
    std::chrono::steady_clock::time_point heard_at = std::chrono::steady_clock::now();
    bool closing = false;
    CloseReason reason = server_stops();

protected:
    virtual void wake() = 0;  // ends the waits of the stream
};

// Reads one message. Returns nullopt when the connection has ended or the message is larger than
// `max_num_bytes`; the socket closes then.
boost::asio::awaitable<std::optional<boost::beast::flat_buffer>> read_message(
    std::shared_ptr<ClientSocket> client, std::size_t max_num_bytes);

// Closes the socket of a client that sends nothing, not even the answer to a ping, for so long.
boost::asio::awaitable<void> watch_silence(std::shared_ptr<ClientSocket> client,
                                           std::chrono::milliseconds limit);

}  // namespace divemesh::server
