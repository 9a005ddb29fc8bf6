#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/thread_pool.hpp>
#include <exception>
#include <functional>
#include <mutex>
#include <vector>

#include "storage/sensor_store.hpp"

namespace divemesh::api {

// Group commit of what sensors report: while one transaction is under way the next reports gather,
// and the one after takes them all. Two hundred sensors a second cost a few syncs, and each of them
// is answered when its report is durable. Thread-safe.
class ReportQueue {
public:
    ReportQueue(storage::Catalog& catalog, boost::asio::thread_pool& pool)
        : catalog_(catalog), pool_(pool) {}

    // When it is durable. Throws what storage::SensorStore::receive() gives as failure, what the
    // transaction throws, and Error{Unavailable} when too many are waiting already.
    boost::asio::awaitable<SensorAnswer> submit(storage::IncomingReport report);

private:
    using Done = std::function<void(std::exception_ptr, SensorAnswer)>;
    struct Waiting {
        storage::IncomingReport report;
        Done done;
    };

    void enqueue(storage::IncomingReport report, Done done);
    void commit_all();  // in the pool, until nobody waits
    std::vector<Waiting> take_some();
    void commit(std::vector<Waiting> group);

    storage::Catalog& catalog_;
    boost::asio::thread_pool& pool_;
    std::mutex mutex_;
    std::vector<Waiting> waiting_;
    bool committing_ = false;
};

}  // namespace divemesh::api
