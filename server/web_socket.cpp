#include "server/web_socket.hpp"

#include <string>

namespace divemesh::server {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::chrono::seconds kHandshake{10};  // the opening one and the closing one

CloseReason silent_for(std::chrono::milliseconds limit) {
    return {kSilent, "no sign of life for " + std::to_string(limit.count()) + " ms: connect again"};
}

CloseReason too_large(std::size_t max_num_bytes) {
    return {websocket::close_code::too_big,
            "a message may have " + std::to_string(max_num_bytes) + " bytes: send smaller ones"};
}

}  // namespace

CloseReason server_stops() {
    return {websocket::close_code::going_away, "the server stops: connect again in a moment"};
}

CloseReason token_has_ended() {
    return {websocket::close_code::policy_error,
            "the token was revoked or has expired: connect with a valid one"};
}

ClientSocket::ClientSocket(std::shared_ptr<Connection> below)
    : connection(std::move(below)), socket(connection->stream), silence(socket.get_executor()) {
    socket.control_callback(
        [this](websocket::frame_type, beast::string_view) { heard_at = Clock::now(); });
    socket.text(true);
    socket.read_message_max(0);  // read_message() has a limit, and says so
}

// Beast pings after half of its time and cuts the connection at its end. That is only for a client
// that takes no more bytes, so that it cannot be told why.
void ClientSocket::set_timeouts(const Timeouts& timeouts) {
    websocket::stream_base::timeout timeout;
    timeout.handshake_timeout = kHandshake;
    timeout.idle_timeout = timeouts.web_socket * 5 / 4;
    timeout.keep_alive_pings = true;
    socket.set_option(timeout);
}

void ClientSocket::close(const CloseReason& why) {
    if (!closing) reason = why;
    closing = true;
    silence.cancel();
    wake();
}

asio::awaitable<std::optional<beast::flat_buffer>> read_message(
    std::shared_ptr<ClientSocket> client, std::size_t max_num_bytes) {
    beast::flat_buffer message;
    do {
        const std::size_t room = max_num_bytes + 1 - message.size();
        const auto [failure, n] =
            co_await client->socket.async_read_some(message, room, kAwaitErrors);
        client->heard_at = Clock::now();
        if (failure) {
            client->close(websocket::close_code::going_away);
            co_return std::nullopt;
        }
        if (message.size() > max_num_bytes) {
            client->close(too_large(max_num_bytes));
            co_return std::nullopt;
        }
    } while (!client->socket.is_message_done());
    co_return message;
}

asio::awaitable<void> watch_silence(std::shared_ptr<ClientSocket> client,
                                    std::chrono::milliseconds limit) {
    while (!client->closing) {
        client->silence.expires_at(client->heard_at + limit);
        co_await client->silence.async_wait(kAwaitErrors);
        if (Clock::now() >= client->heard_at + limit) client->close(silent_for(limit));
    }
}

}  // namespace divemesh::server
