#include "server/http_session.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/http/error.hpp>

#include "api/error_response.hpp"
#include "api/router.hpp"
#include "api/target.hpp"
#include "schemas/error.hpp"
#include "server/event_socket.hpp"
#include "server/log.hpp"
#include "server/request_body.hpp"
#include "server/response_writer.hpp"
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

// The client's own id of the request if it is short and plain, else one of ours.
std::string request_id(const std::string& wanted) {
    const bool plain = !wanted.empty() && wanted.size() <= 64 &&
                       std::all_of(wanted.begin(), wanted.end(), [](char c) {
                           return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' ||
                                  c == '_' || c == '.';
                       });
    return plain ? wanted : storage::random_hex(kRequestIdBytes);
}

api::Request to_request(const std::shared_ptr<RequestBody>& body) {
    api::Request request;
    request.stream = body;
    request.method = body->message().method();
    for (const auto& field : body->message()) {
        std::string name(field.name_string());
        std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
            return static_cast<char>(std::tolower(c));
        });
        const auto [entry, is_new] = request.headers.emplace(std::move(name), field.value());
        if (!is_new) entry->second += ", " + std::string(field.value());
    }
    request.id = request_id(request.header("x-request-id"));
    return request;
}

asio::awaitable<api::Response> answer(api::Request request,
                                      std::string target,
                                      api::Services services) {
    std::exception_ptr failure;
    try {
        auto [path, query] = api::parse_target(target);
        request.path = std::move(path);
        request.query = std::move(query);
    } catch (...) {
        failure = std::current_exception();
    }
    if (failure) co_return api::error_response(request, failure);
    co_return co_await api::dispatch(std::move(request), services);
}

void log_request(const api::Request& request,
                 const std::string& target,
                 const api::Response& response,
                 Clock::time_point began) {
    const auto took = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - began);
    log_info({{"event", "request"},
              {"request_id", request.id},
              {"method", std::string(http::to_string(request.method))},
              {"path", target.substr(0, target.find('?'))},
              {"status", static_cast<int>(response.status)},
              {"ms", took.count()}});
}

// What did not parse as HTTP. Nothing for a client that just went away or fell silent.
std::optional<api::Response> refusal(const beast::error_code& error) {
    static const auto& http_errors = http::make_error_code(http::error::end_of_stream).category();
    if (error.category() != http_errors || error == http::error::end_of_stream ||
        error == http::error::partial_message)
        return std::nullopt;
    api::Request request;
    request.id = request_id("");
    if (error == http::error::header_limit)
        return api::problem_response(request,
                                     http::status::request_header_fields_too_large,
                                     "the header is larger than 16 KiB");
    return api::problem_response(
        request, http::status::bad_request, "this is not HTTP/1.1: " + error.message());
}

// Answers one request; false: the connection is of no more use.
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
    connection->on_stop = [body] { body->stop(); };
    const api::Request request = to_request(body);
    const std::string target(body->message().target());
    api::Response response = co_await answer(request, target, context.services);
    log_request(request, target, response, began);
    if (const auto* feed = std::get_if<api::EventFeed>(&response.body)) {
        co_await send_events(connection, body, *feed, context);
        co_return false;
    }
    connection->on_stop = nullptr;
    const bool keep_alive =
        body->message().keep_alive() && body->is_done() && !connection->stopping;
    const WriteOptions options{
        context.timeouts.write, keep_alive, request.method == http::verb::head};
    const bool written =
        co_await write_response(connection, std::move(response), context.services, options);
    co_return written&& keep_alive;
}

// A client that still sends would lose our answer if we just closed: what it sends is read and
// dropped for a moment.
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
    while (goes_on) goes_on = co_await serve_request(connection, context);
    connection->on_stop = nullptr;
    connection->on_abort = nullptr;
    if (connection->stream.socket().is_open()) co_await close_gently(connection);
}

}  // namespace divemesh::server
