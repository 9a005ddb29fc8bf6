#pragma once

#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <string>
#include <vector>

#include "api/body_stream.hpp"
#include "server/connection.hpp"
#include "server/server.hpp"

namespace divemesh::server {

// Returns whether a read failed because the bytes are invalid HTTP; false if the client has gone or
// is silent.
bool is_invalid_http(const boost::beast::error_code& error);

// One request as it arrives over a connection: the header, then the body in parts.
class RequestBody : public api::BodyStream, public std::enable_shared_from_this<RequestBody> {
public:
    using Message = boost::beast::http::request<boost::beast::http::buffer_body>;

    RequestBody(std::shared_ptr<Connection> connection, const Timeouts& timeouts);

    boost::asio::awaitable<boost::beast::error_code> read_header();
    const Message& message() const { return parser_.get(); }
    bool is_done() const { return parser_.is_done(); }  // the next request may follow
    bool is_over_tls() const;
    std::string peer() const;  // the client's address
    std::int64_t received_bytes() const { return received_bytes_; }

    std::optional<std::uint64_t> content_length() const;  // as received

    std::optional<std::int64_t> length_bytes() const override;
    boost::asio::awaitable<api::BodyRead> read(std::span<char> buffer) override;
    bool has_trailer(std::string_view name) const override;
    void must_end_within(std::chrono::seconds time) override;
    void stop() override;
    void note_valid_token() override { connection_->note_valid_token(); }

private:
    boost::asio::awaitable<boost::beast::error_code> skip_empty_line();
    boost::asio::awaitable<boost::beast::error_code> read_some();
    boost::asio::awaitable<boost::beast::error_code> continue_if_expected();
    bool has_more_at_hand();

    std::shared_ptr<Connection> connection_;
    Timeouts timeouts_;
    boost::beast::http::request_parser<boost::beast::http::buffer_body> parser_;
    std::chrono::steady_clock::time_point deadline_ = std::chrono::steady_clock::time_point::max();
    std::vector<std::string> header_names_;  // of a chunked request, which may have trailers
    std::int64_t received_bytes_ = 0;
    bool stopped_ = false;
    std::size_t num_drained_ = 0;  // since it was stopped
    bool reading_ = false;
    bool continued_ = false;
};

}  // namespace divemesh::server
