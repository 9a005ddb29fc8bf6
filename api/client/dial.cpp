#include "api/client/dial.hpp"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/use_future.hpp>
#include <future>

namespace divemesh::api::client {
namespace {

namespace asio = boost::asio;
namespace ssl = boost::asio::ssl;

bool is_distrust(const boost::system::error_code& code) {
    return code.category() == asio::error::get_ssl_category() &&
           ERR_GET_REASON(static_cast<unsigned long>(code.value())) ==
               SSL_R_CERTIFICATE_VERIFY_FAILED;
}

}  // namespace

ssl::context believing_context() {
    ssl::context context(ssl::context::tls_client);
    SSL_CTX_set_min_proto_version(context.native_handle(), TLS1_2_VERSION);
    context.set_default_verify_paths();
    context.set_verify_mode(ssl::verify_peer);
    return context;
}

void expect_host(Stream::Tls& stream, const std::string& host) {
    boost::system::error_code not_an_address;
    asio::ip::make_address(host, not_an_address);  // an address is not sent as SNI (RFC 6066, 3)
    if (not_an_address && !SSL_set_tlsext_host_name(stream.native_handle(), host.c_str()))
        throw Error(ErrorCode::InvalidArgument, host + " is not a host name for TLS");
    stream.set_verify_callback(ssl::host_name_verification(host));
}

std::unique_ptr<ssl::context> client_tls(const ServerAddress& server) {
    if (!server.tls) return nullptr;
    auto context = std::make_unique<ssl::context>(believing_context());
    boost::system::error_code failure;
    if (!server.ca_file.empty()) context->load_verify_file(server.ca_file, failure);
    if (failure)
        throw Error(ErrorCode::InvalidArgument,
                    server.ca_file + " contains no PEM certificates: " + failure.message());
    return context;
}

Stream dial(asio::io_context& context,
            const ServerAddress& server,
            ssl::context* tls,
            std::chrono::milliseconds timeout) {
    const auto finish = [&context](std::future<void> operation) {
        context.restart();
        context.run();
        operation.get();
    };
    asio::ip::tcp::resolver resolver(context);
    const auto endpoints = resolver.resolve(server.host, server.port);
    Stream stream(asio::ip::tcp::socket(context), tls);
    auto connected = std::promise<void>();
    stream.expires_after(timeout);
    stream.next_layer().async_connect(
        endpoints, [&](const boost::system::error_code& failure, const auto&) {
            if (failure)
                connected.set_exception(
                    std::make_exception_ptr(boost::system::system_error(failure)));
            else
                connected.set_value();
        });
    finish(connected.get_future());
    stream.socket().set_option(asio::ip::tcp::no_delay(true));
    if (stream.tls() == nullptr) return stream;
    expect_host(*stream.tls(), server.host);
    stream.expires_after(timeout);
    finish(stream.tls()->async_handshake(ssl::stream_base::client, asio::use_future));
    return stream;
}

Error connection_error(const ServerAddress& server, const boost::system::error_code& code) {
    if (is_distrust(code))
        return {ErrorCode::Forbidden,
                server.url() + " has a certificate that is not trusted (" + code.message() +
                    "): if it is the right server, give its certificate or that of its issuer with "
                    "--ca-file"};
    return {ErrorCode::Unavailable, "connection to " + server.url() + " failed: " + code.message()};
}

}  // namespace divemesh::api::client
