#pragma once

#include <atomic>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "api/page_file.hpp"
#include "api/rate_limiter.hpp"
#include "api/share_visits.hpp"
#include "api/token_cache.hpp"
#include "api/uploads/hash_cache.hpp"
#include "api/uploads/upload_locks.hpp"
#include "api/webhook_target.hpp"
#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"
#include "storage/queue_forecast.hpp"

namespace divemesh::api {

class DiskReserve;
class KeysInFlight;
class Metrics;
class Readiness;
class ReportQueue;
class SensorHub;

// Limits that protect the server, and rules for what other hosts may do.
struct ServiceLimits {
    std::int64_t max_upload_bytes = std::int64_t{1} << 42;
    std::int64_t min_free_bytes = std::int64_t{256} << 20;  // that new uploads must leave free
    std::chrono::milliseconds upload_lifetime = std::chrono::hours(168);  // without a byte
    std::int64_t max_open_uploads = 1000;                                 // of one project
    std::int64_t max_token_uploads = 200;  // open uploads of one token
    // A client that is slower, measured over `rate_window`, is disconnected.
    std::int64_t min_upload_bytes_per_s = 64;
    std::chrono::milliseconds rate_window = std::chrono::seconds(60);
    std::int64_t max_project_bytes = 0;  // of its dives, results and uploads; 0: no limit
    std::int64_t max_project_dives = 0;  // 0: no limit
    // How long deleted dives and results can be restored before they are removed.
    std::chrono::milliseconds keep_deleted = std::chrono::hours(24 * 30);
    std::chrono::milliseconds keep_lost_workers = std::chrono::minutes(10);  // in the list
    std::chrono::seconds hsts{0};  // how long browsers use nothing but TLS; 0: not stated
    bool tls = false;              // this server speaks TLS itself
    std::vector<std::string> allowed_origins;  // of other pages that may use this server
    std::vector<std::string> frame_ancestors;  // origins whose pages may show ours in a frame
    AllowedNetworks webhook_networks;          // private networks that webhooks may reach
    AllowedNetworks trusted_proxies;           // whose X-Forwarded-For is believed
    std::string public_url;  // that clients use, without a slash at its end; "": not stated
};

// What handlers may use. All of it outlives every connection and is thread-safe.
struct Services {
    storage::Catalog& catalog;
    storage::BlobStore& blobs;
    boost::asio::thread_pool& pool;       // for SQL, disk and hashing; see in_pool()
    boost::asio::thread_pool& transfers;  // for what may take as long as an upload: its own threads
    UploadLocks& locks;
    HashCache& hashes;
    storage::QueueForecast& forecast;
    KeysInFlight& keys;
    TokenCache& tokens;
    ShareVisits& share_visits;
    RateLimiter& rates;          // by token
    RateLimiter& failed_logins;  // by address
    Metrics& metrics;
    Readiness& readiness;
    DiskReserve& reserve;
    ReportQueue& reports;  // of sensors
    SensorHub& sensor_hub;
    // Gives up what can be computed again until the disk has so many bytes free; may be empty.
    const std::function<void(std::int64_t)>& make_room;
    const std::atomic<bool>& stopping;  // long work in the pool gives up once it is true
    const ServiceLimits& limits;
    bool no_auth = false;
    std::span<const PageFile> page = {};  // empty: built without it
};

}  // namespace divemesh::api
