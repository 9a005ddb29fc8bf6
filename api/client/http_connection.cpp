#include "api/client/http_connection.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/use_future.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <future>
#include <optional>

#include "api/client/dial.hpp"
#include "schemas/error.hpp"

namespace divemesh::api::client {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;

constexpr std::size_t kChunkBytes = std::size_t{128} << 10;
constexpr std::uint64_t kMaxBufferedBody = std::uint64_t{64} << 20;

std::string lower(std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) {
        return static_cast<char>(std::tolower(c));
    });
    return result;
}

template <typename Fields>
HttpResponse header_of(const Fields& message) {
    HttpResponse response;
    response.status = static_cast<int>(message.result_int());
    for (const auto& field : message)
        response.headers[lower(field.name_string())] = std::string(field.value());
    return response;
}

}  // namespace

std::string HttpResponse::header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string() : found->second;
}

struct HttpConnection::Implementation {
    ServerAddress server;
    std::chrono::milliseconds stall;
    asio::io_context context;
    std::unique_ptr<asio::ssl::context> tls = client_tls(server);
    std::optional<Stream> stream;
    beast::flat_buffer buffer;
    bool answer_began = false;  // of the exchange under way
    bool body_cut = false;

    // Runs one asynchronous operation to its end, because Beast has timeouts only for these.
    template <typename Start>
    auto run(Start&& start, std::chrono::milliseconds timeout = {}) {
        stream->expires_after(stall + timeout);
        auto result = start();
        context.restart();
        context.run();
        return result.get();
    }

    void connect() {
        stream.reset();
        buffer.clear();
        buffer.reserve(kReadBytes);
        Stream fresh = dial(context, server, tls.get(), stall);
        stream.emplace(std::move(fresh));
    }

    template <typename Body>
    http::request<Body> make_request(const HttpRequest& request) const {
        http::request<Body> message;
        message.method_string(request.method);
        message.target(server.base_path + request.target);
        message.version(11);
        message.set(http::field::host, server.authority());
        message.set(http::field::user_agent, "divemesh");
        for (const auto& [name, value] : request.headers) message.set(name, value);
        return message;
    }

    void write(const HttpRequest& request) {
        auto message = make_request<http::string_body>(request);
        message.body() = request.body;
        if (!request.body.empty() || (request.method != "GET" && request.method != "HEAD"))
            message.content_length(request.body.size());
        run([&] { return http::async_write(*stream, message, asio::use_future); });
    }

    void write(const HttpRequest& request, const BodyRange& body) {
        auto message = make_request<http::empty_body>(request);
        message.content_length(static_cast<std::uint64_t>(body.length));
        http::request_serializer<http::empty_body> header(message);
        run([&] { return http::async_write_header(*stream, header, asio::use_future); });
        std::vector<char> chunk(body.write_bytes);
        for (std::int64_t sent = 0; sent < body.length;) {
            // The server refused the body before all of it was sent. Bytes that arrive over TLS
            // need not be a response.
            if (!stream->tls() && stream->available() > 0) {
                body_cut = true;
                return;
            }
            const auto wanted = static_cast<std::size_t>(std::min<std::int64_t>(
                body.length - sent, static_cast<std::int64_t>(chunk.size())));
            std::size_t filled = 0;
            while (filled < wanted)
                filled +=
                    body.source->read_at(body.offset + sent + static_cast<std::int64_t>(filled),
                                         std::span(chunk).subspan(filled, wanted - filled));
            run([&] {
                return asio::async_write(
                    *stream, asio::buffer(chunk.data(), filled), asio::use_future);
            });
            sent += static_cast<std::int64_t>(filled);
            if (body.on_sent) body.on_sent(sent);
        }
    }

    HttpResponse read(const HttpRequest& request, const BodySink* sink) {
        http::response_parser<http::buffer_body> parser;
        parser.body_limit(boost::none);
        if (request.method == "HEAD") parser.skip(true);
        run([&] { return http::async_read_header(*stream, buffer, parser, asio::use_future); },
            request.timeout);
        answer_began = true;
        HttpResponse response = header_of(parser.get());
        const bool to_sink = sink != nullptr && sink->on_header(response);
        std::array<char, kChunkBytes> chunk;
        while (!parser.is_done()) {
            parser.get().body() = {chunk.data(), chunk.size(), true};
            read_some(parser);
            const std::span<const char> bytes(chunk.data(),
                                              chunk.size() - parser.get().body().size);
            if (to_sink)
                sink->on_bytes(bytes);
            else
                response.body.append(bytes.data(), bytes.size());
            if (response.body.size() > kMaxBufferedBody)
                throw Error(ErrorCode::TooLarge, "the server's answer is too large");
        }
        if (!parser.keep_alive() || body_cut) stream.reset();
        return response;
    }

    void read_some(http::response_parser<http::buffer_body>& parser) {
        try {
            run([&] { return http::async_read_some(*stream, buffer, parser, asio::use_future); });
        } catch (const beast::system_error& error) {
            if (error.code() != http::error::need_buffer) throw;
        }
    }

    // Sends one request. A server that refuses a body may close the connection before it has read
    // all of it; its response counts.
    template <typename Write>
    HttpResponse attempt(const HttpRequest& request, Write&& write_request, const BodySink* sink) {
        answer_began = false;
        body_cut = false;
        std::exception_ptr write_failure;
        try {
            write_request();
        } catch (const beast::system_error& error) {
            if (error.code() == beast::error::timeout) throw;
            write_failure = std::current_exception();
            body_cut = true;
        }
        try {
            return read(request, sink);
        } catch (const beast::system_error&) {
            if (write_failure) std::rethrow_exception(write_failure);
            throw;
        }
    }

    // Sends a request, over a new connection if needed. A kept-alive connection may have been
    // closed meanwhile; that is not a failure of the request as long as no byte of a response has
    // arrived. A POST is never sent twice: it always gets a new connection. A range of a source is
    // not resent either, because some of it may have arrived: the sender asks for the offset first.
    template <typename Write>
    HttpResponse exchange(const HttpRequest& request,
                          Write&& write_request,
                          const BodySink* sink,
                          bool repeatable = true) {
        try {
            const bool reused = stream.has_value() && request.method != "POST";
            if (!reused) connect();
            try {
                return attempt(request, write_request, sink);
            } catch (const beast::system_error& error) {
                if (!reused || !repeatable || answer_began || error.code() == beast::error::timeout)
                    throw;
            }
            connect();
            return attempt(request, write_request, sink);
        } catch (const beast::system_error& error) {
            stream.reset();
            throw connection_error(server, error.code());
        } catch (...) {
            stream.reset();
            throw;
        }
    }
};

HttpConnection::HttpConnection(ServerAddress server, std::chrono::milliseconds stall)
    : implementation_(new Implementation{std::move(server), stall}) {}

HttpConnection::~HttpConnection() = default;
HttpConnection::HttpConnection(HttpConnection&&) noexcept = default;

HttpResponse HttpConnection::send(const HttpRequest& request) {
    return implementation_->exchange(
        request, [&] { implementation_->write(request); }, nullptr);
}

HttpResponse HttpConnection::send(const HttpRequest& request, const BodyRange& body) {
    return implementation_->exchange(
        request, [&] { implementation_->write(request, body); }, nullptr, false);
}

HttpResponse HttpConnection::receive(const HttpRequest& request, const BodySink& sink) {
    return implementation_->exchange(
        request, [&] { implementation_->write(request); }, &sink);
}

const ServerAddress& HttpConnection::server() const { return implementation_->server; }

}  // namespace divemesh::api::client
