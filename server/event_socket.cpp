#include "server/event_socket.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/websocket.hpp>

#include "api/in_pool.hpp"
#include "api/metrics.hpp"
#include "server/log.hpp"
#include "storage/event_store.hpp"
#include "storage/token_store.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using WebSocket = websocket::stream<api::Stream&, false>;  // events are small: no compression
using Clock = std::chrono::steady_clock;

constexpr int kPageEvents = 20;                  // each who has fallen behind has a page of its own
constexpr std::size_t kMaxIncomingBytes = 4096;  // clients have nothing to say
constexpr std::chrono::seconds kTokenTrusted{1};
constexpr auto kAwaitErrors = asio::as_tuple(asio::use_awaitable);

struct EventSocket {
    explicit EventSocket(std::shared_ptr<Connection> below)
        : connection(std::move(below)), socket(connection->stream), pause(socket.get_executor()) {
        pause.expires_at(Clock::time_point::max());  // only ever cancelled
    }

    void close() {
        closing = true;
        pause.cancel();
    }

    std::shared_ptr<Connection> connection;
    WebSocket socket;
    asio::steady_timer pause;
    bool closing = false;
    bool news = true;  // there may be something that it has not been told
};

// Woken by the hub, on the socket's strand, for as long as this lives.
class Watching {
public:
    Watching(EventHub& hub, const std::shared_ptr<EventSocket>& events) : hub_(hub) {
        const auto wake = [events] {
            events->news = true;
            events->pause.cancel();
        };
        const auto executor = events->socket.get_executor();
        watcher_ = hub_.watch([executor, wake] { asio::post(executor, wake); });
    }
    ~Watching() { hub_.unwatch(watcher_); }
    Watching(const Watching&) = delete;
    Watching& operator=(const Watching&) = delete;

private:
    EventHub& hub_;
    std::uint64_t watcher_;
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

// What the catalog has after `feed.since`, for who has fallen behind.
asio::awaitable<ToldEvents> stored_events(api::EventFeed feed, api::Services services) {
    auto ask = [&catalog = services.catalog, feed] {
        return told(storage::EventStore(catalog).since(feed.since, feed.project, kPageEvents));
    };
    co_return co_await api::in_pool(services.pool, std::move(ask));
}

// Whether the token of the stream still opens it.
asio::awaitable<bool> is_entitled(api::EventFeed feed, api::Services services) {
    if (feed.token_id.empty()) co_return true;
    auto ask = [&catalog = services.catalog, id = feed.token_id] {
        return storage::TokenStore(catalog).is_valid(id);
    };
    co_return co_await api::in_pool(services.pool, std::move(ask));
}

// False: the client is gone, or the socket closes.
asio::awaitable<bool> tell(std::shared_ptr<EventSocket> events,
                           ToldEvents page,
                           api::Metrics* metrics) {
    for (const auto& event : page) {
        const auto [error, n] =
            co_await events->socket.async_write(asio::buffer(event->text), kAwaitErrors);
        if (error || events->closing) co_return false;
        ++metrics->told_events;
    }
    co_return true;
}

// Until the client goes or the connection is stopped; returns why it is closed.
asio::awaitable<websocket::close_code> write_events(std::shared_ptr<EventSocket> events,
                                                    api::EventFeed feed,
                                                    SessionContext context) {
    Clock::time_point trusted_until = Clock::now() + kTokenTrusted;
    while (!events->closing) {
        const std::int64_t newest = context.events.newest_sequence();
        if (newest <= feed.since) {
            if (!std::exchange(events->news, false))
                co_await events->pause.async_wait(kAwaitErrors);
            continue;
        }
        if (Clock::now() >= trusted_until) {
            const bool entitled = co_await is_entitled(feed, context.services);
            if (!entitled) co_return websocket::close_code::policy_error;
            trusted_until = Clock::now() + kTokenTrusted;
        }
        auto page = context.events.recent(feed.since, feed.project);
        if (!page) page = co_await stored_events(feed, context.services);
        const bool told_all = co_await tell(events, *page, &context.services.metrics);
        if (!told_all) break;
        // An empty page: the rest is of other projects.
        feed.since = page->empty() ? newest : page->back()->sequence;
    }
    co_return websocket::close_code::going_away;
}

void set_options(WebSocket& socket, const Timeouts& timeouts) {
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
    auto events = std::make_shared<EventSocket>(connection);
    set_options(events->socket, context.timeouts);
    connection->on_stop = [events] { events->close(); };
    connection->on_abort = [events] { beast::get_lowest_layer(events->socket).close(); };
    const auto [refused] = co_await events->socket.async_accept(request->message(), kAwaitErrors);
    if (!refused) {
        const Watching watching(context.events, events);
        auto& metrics = context.services.metrics;
        ++metrics.watchers;
        auto reason = websocket::close_code::internal_error;
        asio::co_spawn(events->socket.get_executor(), read_until_closed(events), asio::detached);
        try {
            reason = co_await write_events(events, feed, context);
        } catch (const std::exception& error) {
            log_warning({{"event", "events_unavailable"}, {"what", error.what()}});
        }
        const auto [unclosed] = co_await events->socket.async_close(reason, kAwaitErrors);
        if (unclosed == beast::error::timeout) ++metrics.dropped_watchers;
        --metrics.watchers;
    }
    beast::get_lowest_layer(events->socket).close();
    connection->on_stop = nullptr;
    connection->on_abort = nullptr;
}

}  // namespace divemesh::server
