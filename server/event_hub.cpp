#include "server/event_hub.hpp"

#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>

#include "api/in_pool.hpp"
#include "server/log.hpp"
#include "storage/event_store.hpp"

namespace divemesh::server {

namespace asio = boost::asio;

constexpr std::chrono::milliseconds kPollEvery{100};

asio::awaitable<void> EventHub::run() {
    asio::steady_timer pause(co_await asio::this_coro::executor);
    while (!stopping_) {
        if (num_watchers_ > 0) {
            try {
                auto ask = [this] { return storage::EventStore(catalog_).newest_sequence(); };
                newest_ = co_await api::in_pool(pool_, std::move(ask));
            } catch (const std::exception& error) {
                log_warning({{"event", "events_unavailable"}, {"what", error.what()}});
            }
        }
        pause.expires_after(kPollEvery);
        co_await pause.async_wait(asio::use_awaitable);
    }
}

}  // namespace divemesh::server
