#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/system/error_code.hpp>
#include <chrono>
#include <memory>

#include "api/client/server_address.hpp"
#include "api/stream.hpp"
#include "schemas/error.hpp"

namespace divemesh::api::client {

// TLS 1.2 and later; believes whom the system believes.
boost::asio::ssl::context believing_context();

// Before the handshake: the other end is told which host is meant, and has to prove to be it.
// Throws Error{InvalidArgument} for what is no name.
void expect_host(Stream::Tls& stream, const std::string& host);

// What a client's connections to a server share: whom it believes. Null: no TLS.
// Throws Error{InvalidArgument} for a ca_file that cannot be used.
std::unique_ptr<boost::asio::ssl::context> client_tls(const ServerAddress& server);

// A connection to the server, which has proved to be the one of the address where it speaks TLS.
// Nothing else may be under way in `context`. Blocks; throws boost::system::system_error.
Stream dial(boost::asio::io_context& context,
            const ServerAddress& server,
            boost::asio::ssl::context* tls,
            std::chrono::milliseconds timeout);

// Error{Unavailable} for what the network does, Error{Forbidden} for a certificate that is not
// believed: to try again would not help.
Error connection_error(const ServerAddress& server, const boost::system::error_code& code);

}  // namespace divemesh::api::client
