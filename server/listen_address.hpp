#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <string>

namespace divemesh::server {

// Parses "127.0.0.1:8080", "[::1]:0", "localhost:8080". Throws Error{InvalidArgument}.
boost::asio::ip::tcp::endpoint parse_listen_address(const std::string& text);

std::string url_of(const boost::asio::ip::tcp::endpoint& endpoint, bool tls = false);

}  // namespace divemesh::server
