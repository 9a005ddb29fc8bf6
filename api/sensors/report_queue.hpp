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

// Commits sensor reports in groups: while one transaction is under way the next reports gather, and
// the following transaction takes them all. Two hundred reports a second cost a few syncs, and each
// sensor gets its answer when its report is durable. Thread-safe.
class ReportQueue {
public:
    // Publishes durable reports in the sensor hub. Without room on the disk it still stores
    // statuses, but keeps only few previews of a sensor. Commits in the pool.
    ReportQueue(storage::Catalog& catalog,
                boost::asio::thread_pool& pool,
                SensorHub& sensor_hub,
                std::function<bool()> has_room)
        : catalog_(catalog), pool_(pool), sensor_hub_(sensor_hub), has_room_(std::move(has_room)) {}

    // Returns when the report is durable. Throws the failure that storage::SensorStore::receive()
    // returns, what the transaction throws, and Error{Unavailable} if too many reports wait
    // already.
    boost::asio::awaitable<SensorAnswer> submit(storage::IncomingReport report);

private:
    using Done = std::function<void(std::exception_ptr, SensorAnswer)>;
    struct Waiting {
        storage::IncomingReport report;
        Done done;
        std::size_t num_bytes = 0;  // of its images
    };

    void enqueue(storage::IncomingReport report, Done done);
    void commit_all();  // in the pool, until the queue is empty
    std::vector<Waiting> take_some();
    void commit(std::vector<Waiting> group);

    storage::Catalog& catalog_;
    boost::asio::thread_pool& pool_;
    SensorHub& sensor_hub_;
    std::function<bool()> has_room_;
    std::mutex mutex_;
    std::vector<Waiting> waiting_;
    std::size_t waiting_bytes_ = 0;  // of images
    bool committing_ = false;
};

}  // namespace divemesh::api
