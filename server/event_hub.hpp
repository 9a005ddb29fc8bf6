#pragma once

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>

#include "storage/catalog.hpp"

namespace divemesh::server {

// Knows how far the events of the catalog go, for all watchers at once: whatever process wrote
// them, one short query a tenth of a second while anybody watches. The watchers read the events
// themselves, each at the pace of its client, so nothing is queued for a slow one.
class EventHub {
public:
    EventHub(storage::Catalog& catalog, boost::asio::thread_pool& pool)
        : catalog_(catalog), pool_(pool) {}

    boost::asio::awaitable<void> run();  // until stop()
    void stop() { stopping_ = true; }

    std::int64_t newest_sequence() const { return newest_; }
    void watch() { ++num_watchers_; }
    void unwatch() { --num_watchers_; }

private:
    storage::Catalog& catalog_;
    boost::asio::thread_pool& pool_;
    std::atomic<std::int64_t> newest_ = 0;
    std::atomic<int> num_watchers_ = 0;
    std::atomic<bool> stopping_ = false;
};

}  // namespace divemesh::server
