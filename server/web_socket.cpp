#include "server/web_socket.hpp"

#include "api/in_pool.hpp"
#include "storage/token_store.hpp"

namespace divemesh::server {

namespace asio = boost::asio;
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

asio::awaitable<bool> is_entitled(std::string token_id, api::Services services) {
    if (token_id.empty()) co_return true;
    auto ask = [&catalog = services.catalog, id = std::move(token_id)] {
        return storage::TokenStore(catalog).is_valid(id);
    };
    co_return co_await api::in_pool(services.pool, std::move(ask));
}

}  // namespace divemesh::server
