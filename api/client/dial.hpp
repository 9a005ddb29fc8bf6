#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/system/error_code.hpp>
#include <chrono>
#include <memory>

#include "api/client/server_address.hpp"
#include "api/client/stream.hpp"
#include "schemas/error.hpp"

namespace divemesh::api::client {

// Returns a context for TLS 1.2 and later that trusts the system's certificates.
boost::asio::ssl::context believing_context();

// Call before the handshake: sends the host's name to the server (SNI) and requires a certificate
// for it. Throws Error{InvalidArgument} for an invalid name.
void expect_host(Stream::Tls& stream, const std::string& host);

// Returns the TLS context that all connections of a client to a server share, with the certificates
// it trusts; null without TLS. Throws Error{InvalidArgument} for a ca_file that cannot be used.
std::unique_ptr<boost::asio::ssl::context> client_tls(const ServerAddress& server);

// Returns a connection to the server; with TLS the server has proved to be the one of the address.
// `context` must have no other work under way. Blocks; throws boost::system::system_error.
Stream dial(boost::asio::io_context& context,
            const ServerAddress& server,
            boost::asio::ssl::context* tls,
            std::chrono::milliseconds timeout);

// Returns Error{Unavailable} for a network failure, and Error{Forbidden} for a certificate that is
// not trusted, where a retry would not help.
Error connection_error(const ServerAddress& server, const boost::system::error_code& code);

}  // namespace divemesh::api::client
