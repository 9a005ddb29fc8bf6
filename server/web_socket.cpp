#include "server/web_socket.hpp"

namespace divemesh::server {

namespace websocket = boost::beast::websocket;

void set_options(WebSocket& socket, const Timeouts& timeouts, std::size_t max_num_bytes) {
    websocket::stream_base::timeout timeout;
    timeout.handshake_timeout = timeouts.header;
    timeout.idle_timeout = timeouts.web_socket;
    timeout.keep_alive_pings = true;
    socket.set_option(timeout);
    socket.read_message_max(max_num_bytes);
    socket.text(true);
}

}  // namespace divemesh::server
