#include "server/event_socket.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "api/in_pool.hpp"
#include "api/metrics.hpp"
#include "api/sensors/sensor_hub.hpp"
#include "api/token_watch.hpp"
#include "schemas/log.hpp"
#include "server/sensor_feed.hpp"
#include "server/web_socket.hpp"
#include "storage/event_store.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using Clock = std::chrono::steady_clock;

constexpr int kPageEvents = 20;                  // per client that has fallen behind
constexpr std::size_t kMaxIncomingBytes = 4096;  // clients have no messages to send

class EventSocket : public ClientSocket {
public:
    explicit EventSocket(std::shared_ptr<Connection> below)
        : ClientSocket(std::move(below)), pause(socket.get_executor()) {}

    asio::steady_timer pause;
    bool has_pending = true;  // there may be events it has not received

private:
    void wake() override { pause.cancel(); }
};

CloseReason cannot_read_events() {
    return {websocket::close_code::internal_error,
            "the events cannot be read now: connect again, with ?since= the last one"};
}

// Wakes the socket, on its strand, when the event hub or the sensor hub has something new, until it
// is destroyed.
class Watching {
public:
    Watching(EventHub& hub,
             api::SensorHub& sensor_hub,
             const api::EventFeed& feed,
             const std::shared_ptr<EventSocket>& events)
        : hub_(hub), sensor_hub_(sensor_hub) {
        const auto wake = [events] {
            events->has_pending = true;
            events->pause.cancel();
        };
        const auto executor = events->socket.get_executor();
        const auto on_change = [executor, wake] { asio::post(executor, wake); };
        watcher_ = hub_.watch(on_change);
        sensor_watcher_ = sensor_hub_.watch(feed.sensors, on_change);
    }
    ~Watching() {
        hub_.unwatch(watcher_);
        sensor_hub_.unwatch(sensor_watcher_);
    }
    Watching(const Watching&) = delete;
    Watching& operator=(const Watching&) = delete;

private:
    EventHub& hub_;
    api::SensorHub& sensor_hub_;
    std::uint64_t watcher_;
    std::uint64_t sensor_watcher_;
};

// Answers pings and notices when the client disconnects; drops its messages.
asio::awaitable<void> read_until_closed(std::shared_ptr<EventSocket> events) {
    const std::shared_ptr<ClientSocket> client = events;
    while (!client->closing) co_await read_message(client, kMaxIncomingBytes);
}

// Returns the catalog's events after `feed.since`, for a client that has fallen behind.
asio::awaitable<SerialisedEvents> stored_events(api::EventFeed feed, api::Services services) {
    auto ask = [&catalog = services.catalog, feed] {
        return serialised(
            storage::EventStore(catalog).since(feed.since, feed.project, kPageEvents));
    };
    co_return co_await api::in_pool(services.pool, std::move(ask));
}

// Returns false if the client is gone, or the socket closes.
asio::awaitable<bool> tell(std::shared_ptr<EventSocket> events,
                           SerialisedEvents page,
                           api::Metrics* metrics) {
    for (const auto& event : page) {
        const auto [error, n] =
            co_await events->socket.async_write(asio::buffer(event->text), kAwaitErrors);
        if (error || events->closing) co_return false;
        ++metrics->serialised_events;
    }
    co_return true;
}

// Sends the due frames of the sensors.
asio::awaitable<bool> send_sensor_frames(std::shared_ptr<EventSocket> events,
                                         SensorFeed* sensors,
                                         api::Metrics* metrics) {
    while (auto frame = sensors->next(Clock::now())) {
        const auto [error, n] =
            co_await events->socket.async_write(asio::buffer(*frame), kAwaitErrors);
        if (error || events->closing) co_return false;
        ++metrics->serialised_events;
    }
    co_return true;
}

// Waits for something new, or until the next sensor frame is due.
asio::awaitable<void> wait_for_change(std::shared_ptr<EventSocket> events,
                                      Clock::time_point next_at) {
    if (std::exchange(events->has_pending, false)) co_return;
    events->pause.expires_at(next_at);
    co_await events->pause.async_wait(kAwaitErrors);
}

// Sends events until the client disconnects or the socket closes.
asio::awaitable<void> write_events(std::shared_ptr<EventSocket> events,
                                   api::EventFeed feed,
                                   SessionContext context) {
    api::TokenWatch token(feed.token_id);
    SensorFeed sensors(context.services.sensor_hub, feed.sensors);
    while (!events->closing) {
        const std::int64_t newest = context.events.newest_sequence();
        const bool is_due = sensors.next_at() <= Clock::now();
        if (newest <= feed.since && !is_due) {
            co_await wait_for_change(events, sensors.next_at());
            continue;
        }
        const bool is_valid = co_await token.is_valid_now(context.services);
        if (!is_valid) co_return events->close(token_has_ended());
        const bool sent_sensors =
            co_await send_sensor_frames(events, &sensors, &context.services.metrics);
        if (!sent_sensors) co_return;
        if (newest <= feed.since) continue;
        auto page = context.events.recent(feed.since, feed.project);
        if (!page) page = co_await stored_events(feed, context.services);
        const bool told_all = co_await tell(events, *page, &context.services.metrics);
        if (!told_all) co_return;
        // An empty page: the other events belong to other projects.
        feed.since = page->empty() ? newest : page->back()->sequence;
    }
}

}  // namespace

asio::awaitable<void> send_events(std::shared_ptr<Connection> connection,
                                  std::shared_ptr<RequestBody> request,
                                  api::EventFeed feed,
                                  SessionContext context) {
    connection->stream.expires_never();  // from here on the WebSocket has timeouts of its own
    auto events = std::make_shared<EventSocket>(connection);
    events->set_timeouts(context.timeouts);
    connection->on_stop = [events] { events->close(server_stops()); };
    connection->on_abort = [events] { beast::get_lowest_layer(events->socket).close(); };
    const auto [refused] = co_await events->socket.async_accept(request->message(), kAwaitErrors);
    if (!refused) {
        const Watching watching(context.events, context.services.sensor_hub, feed, events);
        auto& metrics = context.services.metrics;
        ++metrics.watchers;
        const auto executor = events->socket.get_executor();
        asio::co_spawn(executor, read_until_closed(events), asio::detached);
        asio::co_spawn(
            executor, watch_silence(events, context.timeouts.web_socket), asio::detached);
        try {
            co_await write_events(events, feed, context);
        } catch (const std::exception& error) {
            log_warning({{"event", "events_unavailable"}, {"what", error.what()}});
            events->close(cannot_read_events());
        }
        events->close(server_stops());  // if there is no other reason yet
        const auto [unclosed] = co_await events->socket.async_close(events->reason, kAwaitErrors);
        if (unclosed == beast::error::timeout || events->reason.code == kSilent)
            ++metrics.dropped_watchers;
        --metrics.watchers;
    }
    beast::get_lowest_layer(events->socket).close();
    connection->on_stop = nullptr;
    connection->on_abort = nullptr;
}

}  // namespace divemesh::server
