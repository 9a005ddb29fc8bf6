#include "server/request_body.hpp"

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/read_size.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;

constexpr std::uint32_t kMaxHeaderBytes = 16 << 10;
constexpr std::size_t kMaxDrainedBytes = std::size_t{16} << 20;
constexpr auto kAwaitErrors = asio::as_tuple(asio::use_awaitable);

}  // namespace

bool is_invalid_http(const beast::error_code& error) {
    static const auto& http_errors = http::make_error_code(http::error::end_of_stream).category();
    return error.category() == http_errors && error != http::error::end_of_stream &&
           error != http::error::partial_message;
}

RequestBody::RequestBody(std::shared_ptr<Connection> connection, const Timeouts& timeouts)
    : connection_(std::move(connection)), timeouts_(timeouts) {
    parser_.header_limit(kMaxHeaderBytes);
    parser_.body_limit(boost::none);  // no body is held in memory; handlers have their own limits
    parser_.eager(true);
}

asio::awaitable<beast::error_code> RequestBody::read_header() {
    connection_->stream.expires_after(timeouts_.header);
    const beast::error_code lost = co_await skip_empty_line();
    if (lost) co_return lost;
    parser_.eager(false);
    const auto [error, n] = co_await http::async_read_header(
        connection_->stream, connection_->buffer, parser_, kAwaitErrors);
    parser_.eager(true);
    connection_->note_received();
    if (!error && parser_.chunked())
        for (const auto& field : message()) header_names_.emplace_back(field.name_string());
    co_return error;
}

// Skips one empty line before the request line (RFC 9112, 2.2).
asio::awaitable<beast::error_code> RequestBody::skip_empty_line() {
    constexpr std::string_view kEmptyLine = "\r\n";
    auto& buffer = connection_->buffer;
    for (;;) {
        const std::string begin(static_cast<const char*>(buffer.data().data()),
                                std::min(buffer.size(), kEmptyLine.size()));
        if (begin == kEmptyLine) buffer.consume(begin.size());
        if (!begin.empty() && begin != "\r") co_return beast::error_code();
        const auto room = buffer.prepare(beast::read_size(buffer, api::client::kReadBytes));
        const auto [error, n] = co_await connection_->stream.async_read_some(room, kAwaitErrors);
        buffer.commit(n);
        if (n > 0) connection_->note_received();
        if (error) co_return error;
    }
}

bool RequestBody::is_over_tls() const { return connection_->stream.tls() != nullptr; }

std::string RequestBody::peer() const {
    beast::error_code gone;
    const auto endpoint = connection_->stream.socket().remote_endpoint(gone);
    return gone ? std::string() : endpoint.address().to_string();
}

std::optional<std::int64_t> RequestBody::length_bytes() const {
    if (parser_.chunked()) return std::nullopt;
    return static_cast<std::int64_t>(content_length().value_or(0));
}

std::optional<std::uint64_t> RequestBody::content_length() const {
    const auto length = parser_.content_length();
    return length ? std::optional<std::uint64_t>(*length) : std::nullopt;
}

asio::awaitable<beast::error_code> RequestBody::continue_if_expected() {
    if (continued_ || !beast::iequals(message()[http::field::expect], "100-continue"))
        co_return beast::error_code();
    continued_ = true;
    http::response<http::empty_body> go_on(http::status::continue_, 11);
    const auto [error, n] = co_await http::async_write(connection_->stream, go_on, kAwaitErrors);
    co_return error;
}

asio::awaitable<beast::error_code> RequestBody::read_some() {
    const auto idle = std::chrono::steady_clock::now() + timeouts_.body;
    connection_->stream.expires_at(std::min(idle, deadline_));
    reading_ = true;
    const auto [error, n] = co_await http::async_read_some(
        connection_->stream, connection_->buffer, parser_, kAwaitErrors);
    reading_ = false;
    if (n > 0) connection_->note_received();
    co_return error == http::error::need_buffer ? beast::error_code() : error;
}

asio::awaitable<api::BodyRead> RequestBody::read(std::span<char> buffer) {
    using State = api::BodyRead::State;
    if (parser_.is_done()) co_return api::BodyRead{0, State::End};
    if (stopped_ && !has_more_at_hand()) co_return api::BodyRead{0, State::Stopped};
    beast::error_code error = co_await continue_if_expected();
    auto& body = parser_.get().body();
    body.data = buffer.data();
    body.size = buffer.size();
    body.more = true;
    if (buffer.size() >= api::client::kReadBytes)
        connection_->buffer.reserve(api::client::kReadBytes);
    // Reads one part if the link is slow, as many as fit if more have arrived already.
    bool more = true;
    while (!error && more) {
        error = co_await read_some();
        more = body.size > 0 && !parser_.is_done() && !stopped_ &&
               (body.size == buffer.size() || connection_->stream.available() > 0);
    }
    const std::size_t num_bytes = buffer.size() - body.size;
    received_bytes_ += static_cast<std::int64_t>(num_bytes);
    if (parser_.is_done()) {  // also after stop(): the whole body has been taken
        connection_->buffer.shrink_to_fit();
        co_return api::BodyRead{num_bytes, State::End};
    }
    if (stopped_) {
        num_drained_ += num_bytes;
        co_return api::BodyRead{num_bytes, has_more_at_hand() ? State::More : State::Stopped};
    }
    if (error)
        co_return api::BodyRead{num_bytes, is_invalid_http(error) ? State::Invalid : State::Lost};
    co_return api::BodyRead{num_bytes, State::More};
}

// Keeps what the client had sent before it was stopped, so that a client whose link broke need not
// send it again.
bool RequestBody::has_more_at_hand() {
    return !parser_.is_done() && num_drained_ < kMaxDrainedBytes &&
           connection_->stream.available() > 0;
}

// Beast adds trailers to the fields of the header.
bool RequestBody::has_trailer(std::string_view name) const {
    if (!parser_.is_done() || !parser_.chunked()) return false;
    const auto in_header =
        std::count_if(header_names_.begin(), header_names_.end(), [&](const std::string& other) {
            return beast::iequals(other, name);
        });
    return static_cast<std::ptrdiff_t>(message().count(name)) > in_header;
}

void RequestBody::must_end_within(std::chrono::seconds time) {
    deadline_ = std::chrono::steady_clock::now() + time;
}

void RequestBody::stop() {
    asio::post(connection_->stream.get_executor(), [self = shared_from_this()] {
        self->stopped_ = true;
        if (self->reading_) self->connection_->stream.cancel();
    });
}

}  // namespace divemesh::server
