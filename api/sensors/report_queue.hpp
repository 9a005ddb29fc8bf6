#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/thread_pool.hpp>
#include <exception>
#include <functional>
#include <mutex>
#include <vector>

#include "api/sensors/sensor_hub.hpp"
#include "storage/sensor_store.hpp"

namespace divemesh::api {

// Group commit of what sensors report: while one transaction is under way the next reports gather,
// and the one after takes them all. Two hundred sensors a second cost a few syncs, and each of them
// is answered when its report is durable. Thread-safe.
class ReportQueue {
public:
    // What is durable is published at the desk. Without room on the disk statuses go on, and few
    // previews of a sensor are kept; in the pool.
    ReportQueue(storage::Catalog& catalog,
                boost::asio::thread_pool& pool,
                SensorHub& sensor_hub,
                std::function<bool()> has_room)
        : catalog_(catalog), pool_(pool), sensor_hub_(sensor_hub), has_room_(std::move(has_room)) {}

    // When it is durable. Throws what storage::SensorStore::receive() gives as failure, what the
    // transaction throws, and Error{Unavailable} when too many are waiting already.
    boost::asio::awaitable<SensorAnswer> submit(storage::IncomingReport report);

private:
    using Done = std::function<void(std::exception_ptr, SensorAnswer)>;
    struct Waiting {
        storage::IncomingReport report;
        Done done;
        std::size_t num_bytes = 0;  // of its pictures
    };

    void enqueue(storage::IncomingReport report, Done done);
    void commit_all();  // in the pool, until nobody waits
    std::vector<Waiting> take_some();
    void commit(std::vector<Waiting> group);

    storage::Catalog& catalog_;
    boost::asio::thread_pool& pool_;
    SensorHub& sensor_hub_;
    std::function<bool()> has_room_;
    std::mutex mutex_;
    std::vector<Waiting> waiting_;
    std::size_t waiting_bytes_ = 0;  // of pictures
    bool committing_ = false;
};

}  // namespace divemesh::api
