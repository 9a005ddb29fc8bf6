#include "server/listen_address.hpp"

#include <charconv>

#include "schemas/error.hpp"

namespace divemesh::server {

namespace asio = boost::asio;
using asio::ip::tcp;

tcp::endpoint parse_listen_address(const std::string& text) {
    const auto colon = text.rfind(':');
    std::string host = text.substr(0, colon);
    if (host == "localhost") host = "127.0.0.1";
    if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
    unsigned short port = 0;
    boost::system::error_code bad_host;
    const auto address = asio::ip::make_address(host, bad_host);
    const char* end = text.data() + text.size();
    const char* digits = colon == std::string::npos ? end : text.data() + colon + 1;
    const auto [parsed, bad_port] = std::from_chars(digits, end, port);
    if (bad_host || bad_port != std::errc{} || parsed != end)
        throw Error(ErrorCode::InvalidArgument,
                    "cannot listen on \"" + text + "\": give address:port, e.g. 127.0.0.1:8080");
    return {address, port};
}

std::string url_of(const tcp::endpoint& endpoint, bool tls) {
    const std::string host = endpoint.address().to_string();
    return (tls ? "https://" : "http://") + (endpoint.address().is_v6() ? "[" + host + "]" : host) +
           ":" + std::to_string(endpoint.port());
}

}  // namespace divemesh::server
