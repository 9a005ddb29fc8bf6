#include "server/event_hub.hpp"

#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>

#include "api/in_pool.hpp"
#include "schemas/json.hpp"
#include "schemas/log.hpp"
#include "storage/event_store.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;

constexpr std::chrono::milliseconds kPollEvery{100};
constexpr std::size_t kRecentBytes = std::size_t{4} << 20;
constexpr std::size_t kSliceBytes = std::size_t{64} << 10;
constexpr int kPageEvents = 500;

}  // namespace

SerialisedEvents serialised(const std::vector<Event>& events) {
    SerialisedEvents result;
    for (const Event& event : events)
        result.push_back(std::make_shared<const SerialisedEvent>(SerialisedEvent{
            event.sequence,
            event.project,
            nlohmann::json(event).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)}));
    return result;
}

asio::awaitable<void> EventHub::run() {
    asio::steady_timer pause(co_await asio::this_coro::executor);
    while (!stopping_) {
        if (num_watchers() > 0) {
            try {
                co_await poll();
            } catch (const std::exception& error) {
                log_warning({{"event", "events_unavailable"}, {"what", error.what()}});
            }
        }
        pause.expires_after(kPollEvery);
        co_await pause.async_wait(asio::use_awaitable);
    }
}

// The first read, and a read that finds more than a page, start over at the newest event.
asio::awaitable<void> EventHub::poll() {
    auto ask = [this] {
        storage::EventStore store(catalog_);
        const std::int64_t newest = store.newest_sequence();
        if (complete_after_ < 0 || newest - newest_ > kPageEvents)
            return std::pair(newest, std::vector<Event>());
        if (newest == newest_) return std::pair(newest, std::vector<Event>());
        auto events = store.since(newest_, "", kPageEvents);
        const std::int64_t last = events.empty() ? newest : events.back().sequence;
        return std::pair(std::max(newest, last), std::move(events));
    };
    const auto [newest, events] = co_await api::in_pool(pool_, std::move(ask));
    if (newest == newest_ && complete_after_ >= 0) co_return;
    const std::lock_guard lock(mutex_);
    if (events.empty()) {
        recent_.clear();
        recent_bytes_ = 0;
        complete_after_ = newest;
    }
    keep(serialised(events));
    newest_ = newest;
    for (const auto& [watcher, on_change] : watchers_) on_change();
}

void EventHub::keep(const SerialisedEvents& events) {
    for (const auto& event : events) {
        recent_bytes_ += event->text.size();
        recent_.push_back(event);
    }
    while (recent_bytes_ > kRecentBytes) {
        recent_bytes_ -= recent_.front()->text.size();
        complete_after_ = recent_.front()->sequence;
        recent_.pop_front();
    }
}

std::optional<SerialisedEvents> EventHub::recent(std::int64_t sequence,
                                                 const std::string& project) const {
    const std::lock_guard lock(mutex_);
    if (complete_after_ < 0 || sequence < complete_after_) return std::nullopt;
    const auto later = [](std::int64_t than, const auto& event) { return than < event->sequence; };
    auto next = std::upper_bound(recent_.begin(), recent_.end(), sequence, later);
    SerialisedEvents events;
    for (std::size_t bytes = 0; next != recent_.end() && bytes < kSliceBytes; ++next) {
        if (!project.empty() && (*next)->project != project) continue;
        bytes += (*next)->text.size();
        events.push_back(*next);
    }
    return events;
}

std::uint64_t EventHub::watch(std::function<void()> on_change) {
    const std::lock_guard lock(mutex_);
    watchers_.emplace(next_watcher_, std::move(on_change));
    return next_watcher_++;
}

void EventHub::unwatch(std::uint64_t watcher) {
    const std::lock_guard lock(mutex_);
    watchers_.erase(watcher);
}

std::size_t EventHub::num_watchers() const {
    const std::lock_guard lock(mutex_);
    return watchers_.size();
}

}  // namespace divemesh::server
