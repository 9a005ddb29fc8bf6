#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <memory>
#include <optional>
#include <utility>

namespace divemesh::api::client {

// Max bytes of one read. Beast reads into the free room of its buffer; for a buffer without room it
// reads 512 bytes.
constexpr std::size_t kReadBytes = std::size_t{64} << 10;

// One end of a connection between a client and a server, with or without TLS. That is decided where
// it is made, so readers and writers need not know. Its timeouts are those of the socket below.
class Stream {
public:
    using next_layer_type = boost::beast::tcp_stream;
    using executor_type = next_layer_type::executor_type;
    using Tls = boost::beast::ssl_stream<next_layer_type>;

    // `tls` null: plain.
    Stream(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context* tls) {
        if (tls == nullptr)
            plain_.emplace(std::move(socket));
        else
            tls_ = std::make_unique<Tls>(next_layer_type(std::move(socket)), *tls);
    }

    next_layer_type& next_layer() { return tls_ ? tls_->next_layer() : *plain_; }
    const next_layer_type& next_layer() const { return tls_ ? tls_->next_layer() : *plain_; }
    executor_type get_executor() { return next_layer().get_executor(); }
    boost::asio::ip::tcp::socket& socket() { return next_layer().socket(); }
    Tls* tls() { return tls_.get(); }  // null: plain

    template <typename Duration>
    void expires_after(Duration time) {
        next_layer().expires_after(time);
    }
    template <typename Time>
    void expires_at(Time time) {
        next_layer().expires_at(time);
    }
    void expires_never() { next_layer().expires_never(); }
    void cancel() { next_layer().cancel(); }
    void close() { next_layer().close(); }

    // Returns the number of bytes that a read returns without waiting.
    std::size_t available() {
        boost::beast::error_code ignored;
        const auto decrypted = tls_ ? SSL_pending(tls_->native_handle()) : 0;
        return socket().available(ignored) + static_cast<std::size_t>(decrypted);
    }

    template <typename Buffers, typename Token>
    auto async_read_some(const Buffers& buffers, Token&& token) {
        if (tls_) return tls_->async_read_some(buffers, std::forward<Token>(token));
        return plain_->async_read_some(buffers, std::forward<Token>(token));
    }
    template <typename Buffers, typename Token>
    auto async_write_some(const Buffers& buffers, Token&& token) {
        if (tls_) return tls_->async_write_some(buffers, std::forward<Token>(token));
        return plain_->async_write_some(buffers, std::forward<Token>(token));
    }

private:
    std::optional<next_layer_type> plain_;
    std::unique_ptr<Tls> tls_;  // exactly one of the two is set
};

// Called by boost::beast::websocket to end the connection below it.
template <typename Handler>
void async_teardown(boost::beast::role_type role, Stream& stream, Handler&& handler) {
    using boost::beast::websocket::async_teardown;
    if (auto* tls = stream.tls())
        async_teardown(role, *tls, std::forward<Handler>(handler));
    else
        async_teardown(role, stream.next_layer(), std::forward<Handler>(handler));
}

}  // namespace divemesh::api::client
