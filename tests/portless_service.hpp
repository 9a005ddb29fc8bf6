#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "api/disk_reserve.hpp"
#include "api/http.hpp"
#include "api/idempotency.hpp"
#include "api/metrics.hpp"
#include "api/readiness.hpp"
#include "api/sensors/report_queue.hpp"
#include "api/services.hpp"
#include "server/event_hub.hpp"
#include "server/session_context.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh {

// The service without a port and without tokens, over a catalog with a dive and a job.
class PortlessService {
public:
    PortlessService();
    ~PortlessService();

    const std::string& dive_id() const { return dive_id_; }
    const std::string& job_id() const { return job_id_; }
    storage::Catalog& catalog() { return catalog_; }
    storage::BlobStore& blobs() { return *blobs_; }

    // Dispatches one request with a body, without sockets.
    api::Response ask(api::Request request, std::string_view body);

    // Returns what a client receives that sends these bytes and then closes its side. Aborts the
    // process if the connection does not end.
    std::string converse(std::string_view sent);

private:
    api::Services services();

    TemporaryFolder folder_;
    storage::Catalog catalog_;
    std::unique_ptr<storage::BlobStore> blobs_;
    boost::asio::thread_pool pool_{1};
    boost::asio::io_context io_{1};
    server::EventHub events_{catalog_, pool_};
    api::UploadLocks locks_{io_.get_executor()};
    api::HashCache hashes_;
    storage::QueueForecast forecast_;
    api::KeysInFlight keys_;
    api::TokenCache tokens_;
    api::ShareVisits share_visits_;
    api::RateLimiter rates_{0.0, 0.0};
    api::Metrics metrics_;
    api::Readiness readiness_;
    api::DiskReserve reserve_{folder_ / "reserve"};
    api::SensorHub sensor_hub_;
    api::ReportQueue reports_{catalog_, pool_, sensor_hub_, [] { return true; }};
    std::function<void(std::int64_t)> make_room_;
    std::atomic<bool> stopping_ = false;
    api::ServiceLimits limits_;
    std::string dive_id_;
    std::string job_id_;
};

}  // namespace divemesh
