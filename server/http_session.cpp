#include "server/http_session.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/http/error.hpp>

#include "api/error_response.hpp"
#include "api/metrics.hpp"
#include "api/router.hpp"
#include "schemas/log.hpp"
#include "server/event_socket.hpp"
#include "server/forwarded.hpp"
#include "server/request_body.hpp"
#include "server/request_head.hpp"
#include "server/response_writer.hpp"
#include "server/sensor_socket.hpp"
#include "storage/ids.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kLinger{1};
constexpr std::size_t kLingerBytes = std::size_t{4} << 20;
constexpr std::size_t kRequestIdBytes = 8;

// Returns the client's own request id if it is short and plain, otherwise a new one.
std::string request_id(const std::string& wanted) {
    const bool plain = !wanted.empty() && wanted.size() <= 64 &&
                       std::all_of(wanted.begin(), wanted.end(), [](char c) {
                           return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' ||
                                  c == '_' || c == '.';
                       });
    return plain ? wanted : storage::random_hex(kRequestIdBytes);
}

// Returns the trace id of "00-<32 hex>-<16 hex>-<2 hex>" (W3C Trace Context); "" for any other
// form.
std::string trace_id(const std::string& traceparent) {
    constexpr std::string_view kForm = "00-xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx-xxxxxxxxxxxxxxxx-xx";
    if (traceparent.size() != kForm.size()) return "";
    for (std::size_t i = 0; i < kForm.size(); ++i) {
        const char c = traceparent[i];
        const bool hex = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
        if (kForm[i] == 'x' ? !hex : c != kForm[i]) return "";
    }
    return traceparent.substr(3, 32);
}

api::Request to_request(const std::shared_ptr<RequestBody>& body,
                        const api::ServiceLimits& limits) {
    api::Request request;
    request.stream = body;
    request.method = body->message().method();
    request.target = body->message().target();
    for (const auto& field : body->message()) {
        std::string name(field.name_string());
        std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
            return static_cast<char>(std::tolower(c));
        });
        const auto [entry, is_new] = request.headers.emplace(std::move(name), field.value());
        if (!is_new) entry->second += ", " + std::string(field.value());
    }
    request.id = request_id(request.header("x-request-id"));
    request.trace_id = trace_id(request.header("traceparent"));
    request.peer = body->peer();
    request.is_https = body->is_over_tls();
    believe_proxies(request, limits.trusted_proxies);
    return request;
}

void log_request(const api::Request& request, const api::Response& response, Clock::duration took) {
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(took);
    nlohmann::json line = {{"event", "request"},
                           {"request_id", request.id},
                           {"method", std::string(http::to_string(request.method))},
                           {"path", request.target.substr(0, request.target.find('?'))},
                           {"status", static_cast<int>(response.status)},
                           {"peer", request.peer},
                           {"ms", ms.count()}};
    if (!request.trace_id.empty()) line["trace_id"] = request.trace_id;
    if (!response.token_id.empty()) line["token"] = response.token_id;
    log_info(line);
}

void count_bytes(const RequestBody& body, const api::Response& response, api::Metrics& metrics) {
    if (response.uploaded_bytes)
        metrics.uploaded_bytes.observe(static_cast<double>(*response.uploaded_bytes));
    metrics.received_bytes += body.received_bytes();
    if (const auto* text = std::get_if<std::string>(&response.body))
        metrics.sent_bytes += static_cast<std::int64_t>(text->size());
    if (const auto* file = std::get_if<api::FilePart>(&response.body))
        metrics.sent_bytes += file->length;
}

// Returns the response to invalid HTTP; nullopt if the client just disconnected or fell silent.
std::optional<api::Response> refusal(const beast::error_code& error) {
    if (!is_invalid_http(error)) return std::nullopt;
    api::Request request;
    request.id = request_id("");
    auto response = error == http::error::header_limit
                        ? api::problem_response(request,
                                                http::status::request_header_fields_too_large,
                                                "the header is larger than 16 KiB")
                        : api::problem_response(request,
                                                http::status::bad_request,
                                                "the request is not HTTP/1.1: " + error.message());
    response.set("X-Request-Id", request.id);
    return response;
}

// Returns the response to a request whose header is refused; nullopt if it may be served.
std::optional<api::Response> refuse_head(const RequestBody& body, const api::Request& request) {
    const auto fault = find_head_fault(body);
    if (!fault) return std::nullopt;
    auto response = api::problem_response(request, fault->status, fault->detail);
    response.set("X-Request-Id", request.id);
    return response;
}

// Serves one request. Returns false if the connection cannot be used any more.
asio::awaitable<bool> serve_request(std::shared_ptr<Connection> connection,
                                    SessionContext context) {
    auto body = std::make_shared<RequestBody>(connection, context.timeouts);
    connection->on_stop = [raw = connection.get()] { raw->stream.cancel(); };
    if (connection->stopping) co_return false;
    const beast::error_code error = co_await body->read_header();
    const WriteOptions last{context.timeouts.write, false, false};
    if (error) {
        auto refused = refusal(error);
        if (!refused) co_return false;
        co_await write_response(connection, std::move(*refused), context.services, last);
        co_return false;
    }
    const auto began = Clock::now();
    connection->set_serving(true);
    connection->on_stop = [body] { body->stop(); };
    const api::Request request = to_request(body, context.services.limits);
    auto answered = refuse_head(*body, request);
    const bool is_framed = !answered;
    if (is_framed) answered = co_await api::dispatch(request, context.services);
    api::Response response = std::move(*answered);
    const auto took = Clock::now() - began;
    context.services.metrics.count_request(response.route, response.status, took);
    count_bytes(*body, response, context.services.metrics);
    log_request(request, response, took);
    if (const auto* feed = std::get_if<api::EventFeed>(&response.body)) {
        co_await send_events(connection, body, *feed, context);
        co_return false;
    }
    if (const auto* stream = std::get_if<api::SensorStream>(&response.body)) {
        co_await hear_sensor(connection, body, request, *stream, context);
        co_return false;
    }
    connection->on_stop = nullptr;
    const bool keep_alive =
        is_framed && body->message().keep_alive() && body->is_done() && !connection->stopping;
    const WriteOptions options{context.timeouts.write,
                               keep_alive,
                               request.method == http::verb::head,
                               body->message().version() >= 11};
    const bool written =
        co_await write_response(connection, std::move(response), context.services, options);
    connection->set_serving(false);
    co_return written&& keep_alive;
}

// Returns false if the client does not support the server's TLS, or takes too long.
asio::awaitable<bool> shake_hands(std::shared_ptr<Connection> connection,
                                  std::chrono::milliseconds timeout) {
    connection->stream.expires_after(timeout);
    const auto [error] = co_await connection->stream.tls()->async_handshake(
        asio::ssl::stream_base::server, asio::as_tuple(asio::use_awaitable));
    connection->note_received();
    co_return !error;
}

// Closes TLS; does not wait for the client to confirm.
asio::awaitable<void> end_tls(std::shared_ptr<Connection> connection) {
    connection->stream.expires_after(kLinger);
    co_await connection->stream.tls()->async_shutdown(asio::as_tuple(asio::use_awaitable));
}

// Closes the connection. A client that is still sending would lose the response if the socket just
// closed, so its bytes are read and dropped for a moment.
asio::awaitable<void> close_gently(std::shared_ptr<Connection> connection) {
    beast::error_code error;
    connection->stream.socket().shutdown(asio::ip::tcp::socket::shutdown_send, error);
    std::vector<char> dropped(std::size_t{64} << 10);
    connection->stream.expires_after(kLinger);
    for (std::size_t num_bytes = 0; !error && num_bytes < kLingerBytes;) {
        const auto [failure, n] = co_await connection->stream.async_read_some(
            asio::buffer(dropped), asio::as_tuple(asio::use_awaitable));
        error = failure;
        num_bytes += n;
    }
    connection->stream.close();
}

}  // namespace

asio::awaitable<void> run_session(std::shared_ptr<Connection> connection, SessionContext context) {
    bool goes_on = true;  // g++ 12 miscompiles a co_await in the condition of a loop
    if (connection->stream.tls() != nullptr) {
        connection->on_stop = [raw = connection.get()] { raw->stream.cancel(); };
        goes_on = co_await shake_hands(connection, context.timeouts.header);
    }
    while (goes_on) goes_on = co_await serve_request(connection, context);
    connection->on_stop = nullptr;
    connection->on_abort = nullptr;
    if (!connection->stream.socket().is_open()) co_return;
    if (connection->stream.tls() != nullptr) co_await end_tls(connection);
    co_await close_gently(connection);
}

}  // namespace divemesh::server
