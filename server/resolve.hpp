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

// Resolves a name with the system's resolver.
Addresses look_up(const std::string& host, const std::string& port);

// Resolves a name within `timeout`. The system's resolver cannot be interrupted, and Asio's asks it
// for one name after the other. So each name is looked up on a thread of its own, which is
// abandoned when it takes longer: throws Error{Unavailable} then, and what `lookup` throws.
boost::asio::awaitable<Addresses> resolve_within(std::string host,
                                                 std::string port,
                                                 std::chrono::milliseconds timeout,
                                                 Lookup lookup = look_up);

}  // namespace divemesh::server
