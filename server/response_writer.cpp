#include "server/response_writer.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http/chunk_encode.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <cerrno>
#include <ctime>
#include <optional>
#include <sys/sendfile.h>
#include <vector>

#include "api/in_pool.hpp"
#include "api/metrics.hpp"
#include "api/token_watch.hpp"
#include "schemas/log.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;

constexpr std::size_t kChunkBytes = std::size_t{128} << 10;
constexpr std::int64_t kDirectBytes = 1 << 20;  // then others get their turn
constexpr auto kAwaitErrors = asio::as_tuple(asio::use_awaitable);

template <typename Body>
http::response<Body> header_of(const api::Response& response, bool keep_alive) {
    http::response<Body> message(response.status, 11);
    message.set(http::field::server, "divemesh");
    message.set(http::field::date, api::http_date(std::time(nullptr)));
    for (const auto& [name, value] : response.headers) message.set(name, value);
    message.keep_alive(keep_alive);
    return message;
}

bool has_no_body(http::status status) {
    return status == http::status::no_content || status == http::status::not_modified;
}

asio::awaitable<bool> write_text(std::shared_ptr<Connection> connection,
                                 api::Response response,
                                 WriteOptions options) {
    auto& text = std::get<std::string>(response.body);
    auto message = header_of<http::string_body>(response, options.keep_alive);
    if (!has_no_body(response.status)) message.content_length(text.size());
    if (!options.head) message.body() = std::move(text);
    connection->stream.expires_after(options.timeout);
    const auto [error, n] = co_await http::async_write(connection->stream, message, kAwaitErrors);
    co_return !error;
}

struct Chunk {
    std::vector<char> bytes;
    std::size_t size = 0;  // 0: unreadable
};

asio::awaitable<Chunk> read_chunk(api::FilePart part, api::Services services, Chunk chunk) {
    chunk.bytes.resize(std::min(kChunkBytes, static_cast<std::size_t>(part.length)));
    try {
        auto read =
            [reader = part.reader, offset = part.offset, bytes = std::span<char>(chunk.bytes)] {
                return reader->read_at(offset, bytes);
            };
        chunk.size = co_await api::in_pool(services.pool, std::move(read));
    } catch (const std::exception& error) {
        chunk.size = 0;
        log_warning({{"event", "blob_unreadable"}, {"what", error.what()}});
    }
    co_return chunk;
}

// Sends from the file into the socket as much as it takes now: no bytes over TLS, or if the blob is
// not a file. Parts through memory come before and between: reads from the disk wait in the pool,
// and a full socket has a timeout.
void send_directly(api::client::Stream& stream, api::FilePart& part) {
    const int file = part.reader->descriptor();
    if (file < 0 || stream.tls() != nullptr) return;
    boost::beast::error_code closed;
    stream.socket().native_non_blocking(true, closed);
    if (closed) return;
    off_t offset = part.offset;
    const off_t end = part.offset + std::min(part.length, kDirectBytes);
    while (offset < end) {
        const auto size = static_cast<std::size_t>(end - offset);
        const auto sent = sendfile(stream.socket().native_handle(), file, &offset, size);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) break;  // the next part will show the error
    }
    part.length -= offset - part.offset;
    part.offset = offset;
}

asio::awaitable<bool> write_file(std::shared_ptr<Connection> connection,
                                 api::Response response,
                                 api::Services services,
                                 WriteOptions options) {
    api::FilePart part = std::get<api::FilePart>(response.body);
    auto message = header_of<http::empty_body>(response, options.keep_alive);
    message.content_length(static_cast<std::uint64_t>(part.length));
    http::response_serializer<http::empty_body> serializer(message);
    connection->stream.expires_after(options.timeout);
    const auto [error, n] =
        co_await http::async_write_header(connection->stream, serializer, kAwaitErrors);
    if (error || options.head) co_return !error;
    Chunk chunk;
    api::TokenWatch token(response.token_id);
    while (part.length > 0) {
        const bool is_valid = co_await token.is_valid_now(services);
        if (!is_valid) co_return false;
        chunk = co_await read_chunk(part, services, std::move(chunk));
        if (chunk.size == 0) co_return false;
        connection->stream.expires_after(options.timeout);
        const auto [failure, sent] = co_await asio::async_write(
            connection->stream, asio::buffer(chunk.bytes.data(), chunk.size), kAwaitErrors);
        if (failure) co_return false;
        part.offset += static_cast<std::int64_t>(sent);
        part.length -= static_cast<std::int64_t>(sent);
        send_directly(connection->stream, part);
    }
    co_return true;
}

// Returns the size of the next part, 0 at the end; nullopt if it cannot be made.
asio::awaitable<std::optional<std::size_t>> read_part(std::shared_ptr<api::BodySource> source,
                                                      api::Services services,
                                                      std::span<char> bytes) {
    std::optional<std::size_t> size;
    try {
        auto read = [source, bytes] { return source->read(bytes); };
        size = co_await api::in_pool(services.pool, std::move(read));
    } catch (const std::exception& error) {
        log_warning({{"event", "body_not_made"}, {"what", error.what()}});
    }
    co_return size;
}

asio::awaitable<bool> write_part(std::shared_ptr<Connection> connection,
                                 asio::const_buffer part,
                                 bool chunked) {
    if (!chunked) {
        const auto [error, n] = co_await asio::async_write(connection->stream, part, kAwaitErrors);
        co_return !error;
    }
    const auto chunk = http::make_chunk(part);
    const auto [error, n] = co_await asio::async_write(connection->stream, chunk, kAwaitErrors);
    co_return !error;
}

// A body that cannot be completed has no last chunk, so the client sees that it is cut off.
// HTTP/1.0 knows no chunks: there the end of the connection is its end.
asio::awaitable<bool> write_stream(std::shared_ptr<Connection> connection,
                                   api::Response response,
                                   api::Services services,
                                   WriteOptions options) {
    const auto source = std::get<api::StreamedBody>(response.body).source;
    auto message = header_of<http::empty_body>(response, options.keep_alive && options.chunked);
    message.chunked(options.chunked);
    http::response_serializer<http::empty_body> serializer(message);
    connection->stream.expires_after(options.timeout);
    const auto [error, n] =
        co_await http::async_write_header(connection->stream, serializer, kAwaitErrors);
    if (error || options.head) co_return !error;
    std::vector<char> bytes(kChunkBytes);
    api::TokenWatch token(response.token_id);
    for (;;) {
        const bool is_valid = co_await token.is_valid_now(services);
        if (!is_valid) co_return false;
        const auto size = co_await read_part(source, services, bytes);
        if (!size) co_return false;
        connection->stream.expires_after(options.timeout);
        if (*size == 0) break;
        const asio::const_buffer part(bytes.data(), *size);
        const bool sent = co_await write_part(connection, part, options.chunked);
        if (!sent) co_return false;
        services.metrics.sent_bytes += static_cast<std::int64_t>(*size);
    }
    if (!options.chunked) co_return false;
    const auto end = http::make_chunk_last();
    const auto [failure, sent] = co_await asio::async_write(connection->stream, end, kAwaitErrors);
    co_return !failure;
}

}  // namespace

asio::awaitable<bool> write_response(std::shared_ptr<Connection> connection,
                                     api::Response response,
                                     api::Services services,
                                     WriteOptions options) {
    if (std::holds_alternative<api::FilePart>(response.body))
        co_return co_await write_file(connection, std::move(response), services, options);
    if (std::holds_alternative<api::StreamedBody>(response.body))
        co_return co_await write_stream(connection, std::move(response), services, options);
    co_return co_await write_text(connection, std::move(response), options);
}

}  // namespace divemesh::server
