#include "api/client/event_stream.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/use_future.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/field.hpp>
#include <boost/beast/websocket.hpp>
#include <future>

#include "api/client/dial.hpp"
#include "schemas/json.hpp"

namespace divemesh::api::client {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;

constexpr std::chrono::seconds kConnectTimeout{10};
constexpr std::size_t kMaxMessageBytes = std::size_t{1} << 20;

}  // namespace

struct EventStream::Implementation {
    explicit Implementation(const ServerAddress& server)
        : server_url(server.url()),
          tls(client_tls(server)),
          socket(dial(context, server, tls.get(), kConnectTimeout)) {}

    std::string server_url;
    std::unique_ptr<asio::ssl::context> tls;
    asio::io_context context;
    websocket::stream<Stream, false> socket;  // events are small: no compression
    beast::flat_buffer buffer;
    std::future<std::size_t> reading;  // an operation may outlive the call that began it

    template <typename Result>
    Result finish(std::future<Result> operation) {
        context.restart();
        context.run();
        return operation.get();
    }

    void subscribe(const Account& account, std::optional<std::int64_t> since) {
        socket.next_layer().expires_never();  // from here on the WebSocket has timeouts of its own
        auto timeout = websocket::stream_base::timeout::suggested(beast::role_type::client);
        timeout.keep_alive_pings = true;
        socket.set_option(timeout);
        socket.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
            for (const auto& [name, value] : authorization(account)) request.set(name, value);
        }));
        socket.read_message_max(kMaxMessageBytes);
        const std::string target = account.server.base_path + "/api/v1/events" +
                                   (since ? "?since=" + std::to_string(*since) : "");
        finish(socket.async_handshake(account.server.authority(), target, asio::use_future));
    }

    std::optional<Event> next(std::chrono::milliseconds timeout) {
        if (!reading.valid()) reading = socket.async_read(buffer, asio::use_future);
        context.restart();
        context.run_for(timeout);
        if (reading.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
            return std::nullopt;
        reading.get();
        const std::string text = beast::buffers_to_string(buffer.data());
        buffer.clear();
        return nlohmann::json::parse(text).get<Event>();
    }
};

EventStream::EventStream(const Account& account, std::optional<std::int64_t> since) {
    try {
        implementation_ = std::make_unique<Implementation>(account.server);
        implementation_->subscribe(account, since);
    } catch (const beast::system_error& error) {
        throw connection_error(account.server, error.code());
    }
}

EventStream::~EventStream() = default;

std::optional<Event> EventStream::next(std::chrono::milliseconds timeout) {
    try {
        return implementation_->next(timeout);
    } catch (const beast::system_error& error) {
        throw Error(ErrorCode::Unavailable,
                    "events of " + implementation_->server_url + ": " + error.code().message());
    } catch (const nlohmann::json::exception& error) {
        throw Error(ErrorCode::Unavailable,
                    "events of " + implementation_->server_url + ": " + error.what());
    }
}

}  // namespace divemesh::api::client
