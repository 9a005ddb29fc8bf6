#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace divemesh::server {

using Addresses = std::vector<boost::asio::ip::tcp::endpoint>;
// Blocks; throws boost::system::system_error.
using Lookup = std::function<Addresses(const std::string& host, const std::string& port)>;

// As the system resolves names.
Addresses look_up(const std::string& host, const std::string& port);

// The system's resolver cannot be interrupted, and Asio's asks it one name after the other: each
// name is looked up on a thread of its own, which is left behind when it takes longer than
// `patience`. Throws Error{Unavailable} then, and what `lookup` throws.
boost::asio::awaitable<Addresses> resolve_within(std::string host,
                                                 std::string port,
                                                 std::chrono::milliseconds timeout,
                                                 Lookup lookup = look_up);

}  // namespace divemesh::server
