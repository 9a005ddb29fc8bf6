#include "server/event_socket.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/websocket.hpp>

#include "api/in_pool.hpp"
#include "schemas/json.hpp"
#include "server/log.hpp"
#include "storage/event_store.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

constexpr int kPageEvents = 100;
constexpr std::size_t kMaxIncomingBytes = 4096;  // clients have nothing to say
constexpr std::chrono::milliseconds kLookEvery{50};
constexpr auto kAwaitErrors = asio::as_tuple(asio::use_awaitable);

struct EventSocket {
    explicit EventSocket(beast::tcp_stream stream)
        : socket(std::move(stream)), pause(socket.get_executor()) {}

    void close() {
        closing = true;
        pause.cancel();
    }

    websocket::stream<beast::tcp_stream> socket;
    asio::steady_timer pause;
    bool closing = false;
};

class Watching {
public:
    explicit Watching(EventHub& hub) : hub_(hub) { hub_.watch(); }
    ~Watching() { hub_.unwatch(); }
    Watching(const Watching&) = delete;
    Watching& operator=(const Watching&) = delete;

private:
    EventHub& hub_;
};

// Answers pings and notices that the client has gone; what it says is dropped.
asio::awaitable<void> read_until_closed(std::shared_ptr<EventSocket> events) {
    beast::flat_buffer dropped;
    for (beast::error_code error; !error; dropped.clear()) {
        const auto [failure, n] = co_await events->socket.async_read(dropped, kAwaitErrors);
        error = failure;
    }
    events->close();
}

asio::awaitable<std::vector<Event>> next_events(api::EventFeed feed, api::Services services) {
    auto ask = [&catalog = services.catalog, feed] {
        return storage::EventStore(catalog).since(feed.since, feed.project, kPageEvents);
    };
    co_return co_await api::in_pool(services.pool, std::move(ask));
}

asio::awaitable<void> write_events(std::shared_ptr<EventSocket> events,
                                   api::EventFeed feed,
                                   SessionContext context) {
    while (!events->closing) {
        const std::int64_t newest = context.events.newest_sequence();
        if (newest > feed.since) {
            const auto page = co_await next_events(feed, context.services);
            for (const Event& event : page) {
                const std::string text = nlohmann::json(event).dump(
                    -1, ' ', false, nlohmann::json::error_handler_t::replace);
                const auto [error, n] =
                    co_await events->socket.async_write(asio::buffer(text), kAwaitErrors);
                if (error || events->closing) co_return;
                feed.since = event.sequence;
            }
            if (page.size() == kPageEvents) continue;
            feed.since = std::max(feed.since, newest);  // the rest is of other projects
        }
        if (events->closing) co_return;
        events->pause.expires_after(kLookEvery);
        co_await events->pause.async_wait(kAwaitErrors);
    }
}

void set_options(websocket::stream<beast::tcp_stream>& socket, const Timeouts& timeouts) {
    websocket::stream_base::timeout timeout;
    timeout.handshake_timeout = timeouts.header;
    timeout.idle_timeout = timeouts.web_socket;
    timeout.keep_alive_pings = true;
    socket.set_option(timeout);
    socket.read_message_max(kMaxIncomingBytes);
    socket.text(true);
}

}  // namespace

asio::awaitable<void> send_events(std::shared_ptr<Connection> connection,
                                  std::shared_ptr<RequestBody> request,
                                  api::EventFeed feed,
                                  SessionContext context) {
    connection->stream.expires_never();  // from here on the WebSocket has timeouts of its own
    auto events = std::make_shared<EventSocket>(std::move(connection->stream));
    set_options(events->socket, context.timeouts);
    connection->on_stop = [events] { events->close(); };
    connection->on_abort = [events] { beast::get_lowest_layer(events->socket).close(); };
    const auto [refused] = co_await events->socket.async_accept(request->message(), kAwaitErrors);
    if (!refused) {
        const Watching watching(context.events);
        asio::co_spawn(events->socket.get_executor(), read_until_closed(events), asio::detached);
        try {
            co_await write_events(events, feed, context);
        } catch (const std::exception& error) {
            log_warning({{"event", "events_unavailable"}, {"what", error.what()}});
        }
        const auto reason = websocket::close_code::going_away;
        co_await events->socket.async_close(reason, kAwaitErrors);
    }
    beast::get_lowest_layer(events->socket).close();
    connection->on_stop = nullptr;
    connection->on_abort = nullptr;
}

}  // namespace divemesh::server
