#include "server/connection.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <cstdint>

namespace divemesh::server {

namespace asio = boost::asio;
namespace ip = boost::asio::ip;

ip::address client_address(const ip::tcp::socket& socket) {
    boost::system::error_code gone;
    const auto endpoint = socket.remote_endpoint(gone);
    if (gone) return {};
    const ip::address address = endpoint.address();
    if (address.is_v6() && address.to_v6().is_v4_mapped())
        return ip::make_address_v4(ip::v4_mapped, address.to_v6());
    return address;
}

std::string client_of(const ip::address& address) {
    if (address.is_v4()) return address.to_string();
    constexpr std::size_t kNetworkBytes = 8;
    auto bytes = address.to_v6().to_bytes();
    std::fill(bytes.begin() + kNetworkBytes, bytes.end(), std::uint8_t{0});
    return ip::address_v6(bytes).to_string() + "/64";
}

Connection::Connection(ip::tcp::socket socket,
                       const ip::address& client,
                       std::shared_ptr<asio::ssl::context> tls)
    : stream(std::move(socket), tls.get()),
      tls_(std::move(tls)),
      address_(client),
      client_(client_of(client)) {}

void Connection::stop() {
    asio::post(stream.get_executor(), [self = shared_from_this()] {
        self->stopping = true;
        if (self->on_stop) self->on_stop();
    });
}

void Connection::abort() {
    asio::post(stream.get_executor(), [self = shared_from_this()] {
        self->stopping = true;
        if (self->on_abort) self->on_abort();
        self->stream.close();
    });
}

}  // namespace divemesh::server
