#pragma once

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "schemas/event.hpp"
#include "storage/catalog.hpp"

namespace divemesh::server {

// A serialised event: one text for all watchers.
struct SerialisedEvent {
    std::int64_t sequence = 0;
    std::string project;
    std::string text;
};
using SerialisedEvents = std::vector<std::shared_ptr<const SerialisedEvent>>;

// Serialises events, each to one JSON text.
SerialisedEvents serialised(const std::vector<Event>& events);

// Reads the events of the catalog once for all watchers, also those that other processes wrote: one
// short query every 0.1 s while there are watchers. Keeps the newest events, bounded in bytes, so
// that a fast watcher reads memory only; one that has fallen behind reads the catalog at its own
// pace. There are no queues. Thread-safe.
class EventHub {
public:
    EventHub(storage::Catalog& catalog, boost::asio::thread_pool& pool)
        : catalog_(catalog), pool_(pool) {}

    boost::asio::awaitable<void> run();  // until stop()
    void stop() { stopping_ = true; }

    std::int64_t newest_sequence() const { return newest_; }

    // Returns the next events after `sequence`, from memory: 64 KiB of them or a single larger one.
    // Returns nullopt if some of them may no longer be in memory.
    std::optional<SerialisedEvents> recent(std::int64_t sequence, const std::string& project) const;

    // Calls `on_change`, on any thread, whenever there are new events, until unwatch().
    std::uint64_t watch(std::function<void()> on_change);
    void unwatch(std::uint64_t watcher);
    std::size_t num_watchers() const;

private:
    boost::asio::awaitable<void> poll();
    void keep(const SerialisedEvents& events);

    storage::Catalog& catalog_;
    boost::asio::thread_pool& pool_;
    std::atomic<std::int64_t> newest_ = 0;
    std::atomic<bool> stopping_ = false;

    mutable std::mutex mutex_;
    std::map<std::uint64_t, std::function<void()>> watchers_;
    std::uint64_t next_watcher_ = 1;
    std::deque<std::shared_ptr<const SerialisedEvent>> recent_;
    std::size_t recent_bytes_ = 0;
    std::int64_t complete_after_ = -1;  // every later event is in recent_; -1: not read yet
};

}  // namespace divemesh::server
