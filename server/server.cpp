#include "server/server.hpp"

#include <array>
#include <atomic>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <csignal>
#include <thread>
#include <vector>

#include "api/disk_guard.hpp"
#include "api/disk_reserve.hpp"
#include "api/housekeeping.hpp"
#include "api/idempotency.hpp"
#include "api/in_pool.hpp"
#include "api/metrics.hpp"
#include "api/public_url.hpp"
#include "api/readiness.hpp"
#include "api/sensors/report_queue.hpp"
#include "api/uploads/import_dives.hpp"
#include "api/uploads/pending_dives.hpp"
#include "api/uploads/upload_sweeper.hpp"
#include "schemas/error.hpp"
#include "schemas/log.hpp"
#include "server/connections.hpp"
#include "server/event_hub.hpp"
#include "server/first_token.hpp"
#include "server/http_session.hpp"
#include "server/listen_address.hpp"
#include "server/tls.hpp"
#include "server/warning_pace.hpp"
#include "server/webhook_sender.hpp"
#include "storage/data_folder.hpp"
#include "storage/data_id.hpp"
#include "storage/token_store.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;
using asio::ip::tcp;
using namespace std::chrono_literals;

constexpr auto kAwaitErrors = asio::as_tuple(asio::use_awaitable);
constexpr std::chrono::milliseconds kMaxPendingDivesPause = 1h;
constexpr std::chrono::milliseconds kBusyPendingDivesPause = 1s;
constexpr std::chrono::milliseconds kAcceptWarningEvery = 30s;

ServerConfig with_defaults(ServerConfig config) {
    if (config.data.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "give the data folder (--data): the server keeps uploads there while they "
                    "arrive");
    const fs::path data = fs::absolute(config.data);
    std::error_code failure;
    storage::create_data_folder(data, failure);
    if (failure)
        throw Error(ErrorCode::Unavailable,
                    "cannot create the data folder " + data.string() + ": " + failure.message());
    config.data = data;
    if (config.catalog_url.empty())
        config.catalog_url = "sqlite://" + (data / "catalog.db").string();
    if (config.blobs_url.empty()) config.blobs_url = (data / "blobs").string();
    return config;
}

tcp::acceptor open_acceptor(asio::io_context& io, const tcp::endpoint& endpoint) {
    try {
        return {io, endpoint};
    } catch (const boost::system::system_error& error) {
        throw Error(ErrorCode::Unavailable,
                    "cannot listen on " + url_of(endpoint) + ": " + error.code().message());
    }
}

api::ServiceLimits limits_of(const ServerConfig& config) {
    api::ServiceLimits limits;
    limits.max_upload_bytes = config.max_upload_bytes;
    limits.min_free_bytes = config.min_free_bytes;
    limits.upload_lifetime = config.upload_lifetime;
    limits.max_open_uploads = config.max_open_uploads;
    limits.max_token_uploads = config.max_token_uploads;
    limits.min_upload_bytes_per_s = config.min_upload_bytes_per_s;
    limits.rate_window = config.timeouts.rate;
    limits.max_project_bytes = config.max_project_bytes;
    limits.max_project_dives = config.max_project_dives;
    limits.keep_deleted = config.keep_deleted;
    limits.keep_lost_workers = config.keep_lost_workers;
    limits.tls = !config.tls_certificate.empty();
    if (limits.tls) limits.hsts = config.hsts;  // RFC 6797, 7.2
    limits.allowed_origins = config.allowed_origins;
    limits.frame_ancestors = config.frame_ancestors;
    limits.webhook_networks = api::AllowedNetworks(config.webhook_networks);
    limits.trusted_proxies = api::AllowedNetworks(config.trusted_proxies);
    limits.public_url = api::checked_public_url(config.public_url);
    return limits;
}

ConnectionLimits connection_limits_of(const ServerConfig& config) {
    std::vector<std::string> many_clients = config.many_client_networks;
    many_clients.insert(
        many_clients.end(), config.trusted_proxies.begin(), config.trusted_proxies.end());
    return {static_cast<std::size_t>(config.max_connections),
            static_cast<std::size_t>(config.max_address_connections),
            api::AllowedNetworks(many_clients)};
}

// Tells the client the reason, as far as the socket's buffers take it without waiting.
void reject(tcp::socket& socket) {
    static constexpr std::string_view kBody =
        R"({"type":"urn:divemesh:error:unavailable","title":"Service Unavailable","status":503,)"
        R"("detail":"the server has as many connections as it may: try again in a moment"})";
    static const std::string kAnswer =
        "HTTP/1.1 503 Service Unavailable\r\nContent-Type: application/problem+json\r\n"
        "Retry-After: 5\r\nConnection: close\r\nContent-Length: " +
        std::to_string(kBody.size()) + "\r\n\r\n" + std::string(kBody);
    boost::system::error_code ignored;
    socket.non_blocking(true, ignored);
    socket.write_some(asio::buffer(kAnswer), ignored);
    socket.shutdown(tcp::socket::shutdown_send, ignored);
    // To close the socket with an unread request would drop the response.
    std::array<char, 16 << 10> request;
    socket.read_some(asio::buffer(request), ignored);
}

// Opens the blobs that belong to the catalog. Once they do, they are not created anew in a folder
// whose disk is not mounted.
std::unique_ptr<storage::BlobStore> open_blobs(const ServerConfig& config,
                                               storage::Catalog& catalog) {
    auto blobs =
        storage::open_blob_store(config.blobs_url,
                                 storage::has_data_id(catalog) ? storage::Opening::ExistingOnly
                                                               : storage::Opening::CreateIfMissing,
                                 config.data / "staged");
    storage::claim_data(catalog, *blobs);
    return blobs;
}

// Without tokens everybody on the network could do everything, so only this machine may be served.
std::string admit(const ServerConfig& config, bool loopback, storage::Catalog& catalog) {
    if (config.no_auth && !loopback)
        throw Error(ErrorCode::InvalidArgument,
                    "--no-auth is only for loopback addresses, not for " + config.listen +
                        ": leave it out or change --listen");
    if (config.no_auth) return "";
    if (loopback) return make_first_token(catalog, config.data / "admin.token");
    if (storage::TokenStore(catalog).empty())
        throw Error(ErrorCode::InvalidArgument,
                    "there is no token to log in with at " + config.listen +
                        ": create one first (divemesh token create), or start once on loopback");
    return "";
}

}  // namespace

struct Server::Implementation {
    explicit Implementation(ServerConfig given)
        : config(with_defaults(std::move(given))),
          endpoint(parse_listen_address(config.listen)),
          catalog(config.catalog_url),
          blobs(open_blobs(config, catalog)),
          first_token(admit(config, endpoint.address().is_loopback(), catalog)),
          pool(static_cast<std::size_t>(config.num_blocking_threads)),
          transfers(static_cast<std::size_t>(config.num_transfer_threads)),
          events(catalog, pool),
          locks(io.get_executor()),
          acceptor(open_acceptor(io, endpoint)) {
        acceptor.non_blocking(true);
        catalog.reserve(static_cast<std::size_t>(config.num_io_threads) +
                        static_cast<std::size_t>(config.num_blocking_threads) +
                        static_cast<std::size_t>(config.num_transfer_threads));
        endpoint = acceptor.local_endpoint();
    }

    SessionContext context() {
        api::Services services{
            catalog,  *blobs,    pool,           transfers,    locks,      hashes,
            forecast, keys,      tokens,         share_visits, rates,      failed_logins,
            metrics,  readiness, reserve,        reports,      sensor_hub, config.make_room,
            stopping, limits,    config.no_auth, config.page};
        return {services, events, config.timeouts};
    }

    asio::awaitable<void> accept();
    asio::awaitable<void> drain();
    // Runs `work` once; logs an exception as `failed`.
    template <typename Work>
    asio::awaitable<bool> attempt(const char* failed, Work work);
    asio::awaitable<void> sweep();
    asio::awaitable<void> make_pending_dives();
    asio::awaitable<void> import();
    asio::awaitable<void> repeat(void (*round)(const api::Services&),
                                 std::chrono::milliseconds pause);
    void spawn_session(tcp::socket socket);

    ServerConfig config;
    api::ServiceLimits limits = limits_of(config);
    TlsCertificate certificate{config.tls_certificate, config.tls_key};
    tcp::endpoint endpoint;
    storage::Catalog catalog;
    std::unique_ptr<storage::BlobStore> blobs;
    std::string first_token;
    api::HashCache hashes;
    storage::QueueForecast forecast;
    api::KeysInFlight keys;
    api::TokenCache tokens;
    api::ShareVisits share_visits;
    api::RateLimiter rates{config.max_requests_per_s, 2.0 * config.max_requests_per_s};
    api::RateLimiter failed_logins{config.max_failed_logins_per_s,
                                   100.0 * config.max_failed_logins_per_s};
    api::Metrics metrics;
    api::Readiness readiness;
    api::DiskReserve reserve{config.data / "reserve"};
    std::atomic<bool> stopping = false;
    asio::io_context io;
    asio::thread_pool pool;
    asio::thread_pool transfers;
    api::SensorHub sensor_hub;
    api::ReportQueue reports{
        catalog, pool, sensor_hub, [this] { return api::has_room(context().services); }};
    EventHub events;
    api::UploadLocks locks;
    WebhookSender webhooks{context().services};
    Connections connections{connection_limits_of(config)};
    tcp::acceptor acceptor;
};

void Server::Implementation::spawn_session(tcp::socket socket) {
    boost::system::error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    const auto address = client_address(socket);
    const auto connection =
        std::make_shared<Connection>(std::move(socket), address, certificate.current());
    if (!connections.add(connection)) {
        ++metrics.refused_connections;
        if (config.tls_certificate.empty()) reject(connection->stream.socket());
        return;
    }
    ++metrics.connections;
    asio::co_spawn(connection->stream.get_executor(),
                   run_session(connection, context()),
                   [this, connection](const std::exception_ptr& failure) {
                       connections.remove(connection);
                       --metrics.connections;
                       try {
                           if (failure) std::rethrow_exception(failure);
                       } catch (const std::exception& error) {
                           log_warning({{"event", "session_failed"}, {"what", error.what()}});
                       }
                   });
}

asio::awaitable<void> Server::Implementation::accept() {
    asio::steady_timer pause(io);
    WarningPace pace(kAcceptWarningEvery);
    while (!stopping) {
        auto [error, socket] = co_await acceptor.async_accept(asio::make_strand(io), kAwaitErrors);
        if (!error) {
            spawn_session(std::move(socket));
        } else if (!stopping) {  // no file descriptor is left, or the client has gone
            if (const auto num_left_out = pace.pass(WarningPace::Clock::now()))
                log_warning({{"event", "accept_failed"},
                             {"what", error.message()},
                             {"num_left_out", *num_left_out}});
            pause.expires_after(50ms);
            co_await pause.async_wait(kAwaitErrors);
        }
    }
}

template <typename Work>
asio::awaitable<bool> Server::Implementation::attempt(const char* failed, Work work) {
    std::string failure;
    try {
        co_await work();
    } catch (const std::exception& error) {
        failure = error.what();
    }
    if (!failure.empty()) log_warning({{"event", failed}, {"what", failure}});
    co_return failure.empty();
}

asio::awaitable<void> Server::Implementation::sweep() {
    asio::steady_timer pause(io);
    while (!stopping) {
        auto work = [this] { return api::sweep_uploads(context().services); };
        co_await attempt("sweep_failed", std::move(work));
        pause.expires_after(config.timeouts.sweep);
        co_await pause.async_wait(kAwaitErrors);
    }
}

// Tries at the start, and again at growing intervals while a dive cannot be made: each try reads
// and hashes its bytes.
asio::awaitable<void> Server::Implementation::make_pending_dives() {
    asio::steady_timer timer(io);
    auto pause = config.timeouts.pending_dives;
    while (!stopping) {
        auto pending = api::PendingDives::Failed;
        auto work = [this, &pending]() -> asio::awaitable<void> {
            pending = co_await api::make_pending_dives(context().services);
        };
        co_await attempt("pending_dives_failed", std::move(work));
        if (pending == api::PendingDives::Made) pause = config.timeouts.pending_dives;
        if (pending == api::PendingDives::Failed)
            pause = std::min(2 * pause, kMaxPendingDivesPause);
        timer.expires_after(
            pending == api::PendingDives::Busy ? std::min(pause, kBusyPendingDivesPause) : pause);
        co_await timer.async_wait(kAwaitErrors);
    }
}

// Repeats `round`, which blocks and does not throw, in the pool.
asio::awaitable<void> Server::Implementation::repeat(void (*round)(const api::Services&),
                                                     std::chrono::milliseconds pause) {
    asio::steady_timer timer(io);
    while (!stopping) {
        auto work = [round, services = context().services] { round(services); };
        co_await api::in_pool(pool, std::move(work));
        timer.expires_after(pause);
        co_await timer.async_wait(kAwaitErrors);
    }
}

asio::awaitable<void> Server::Implementation::import() {
    if (config.import_folder.empty()) co_return;
    // A named variable, because g++ 12 destroys a braced argument of a coroutine twice.
    const api::ImportRequest request{
        config.import_folder, config.import_project, config.import_preset};
    auto work = [this, &request] { return api::import_dives(context().services, request); };
    co_await attempt("import_failed", std::move(work));
}

// Waits for uploads to flush and WebSockets to close; aborts connections that take too long.
asio::awaitable<void> Server::Implementation::drain() {
    connections.stop_all();
    asio::steady_timer pause(io);
    const auto end = std::chrono::steady_clock::now() + config.timeouts.stop;
    for (bool aborted = false; connections.count() > 0;) {
        const auto now = std::chrono::steady_clock::now();
        if (now >= end && !aborted) connections.abort_all();
        aborted = now >= end;
        if (now >= end + 1s) break;
        pause.expires_after(10ms);
        co_await pause.async_wait(kAwaitErrors);
    }
    blobs->stop_transfers();  // what is not yet in the object store stays staged
    io.stop();
}

Server::Server(ServerConfig config)
    : implementation_(std::make_unique<Implementation>(std::move(config))) {}

Server::~Server() = default;

std::string Server::url() const {
    return url_of(implementation_->endpoint, !implementation_->config.tls_certificate.empty());
}
const std::string& Server::first_token() const { return implementation_->first_token; }
const ServerConfig& Server::config() const { return implementation_->config; }

void Server::run() {
    std::signal(SIGPIPE, SIG_IGN);  // sendfile() has no flag against it
    Implementation& self = *implementation_;
    asio::co_spawn(self.io, self.make_pending_dives(), asio::detached);
    asio::co_spawn(self.io, self.accept(), asio::detached);
    asio::co_spawn(self.io, self.sweep(), asio::detached);
    asio::co_spawn(self.io, self.import(), asio::detached);
    asio::co_spawn(self.io, self.events.run(), asio::detached);
    asio::co_spawn(self.io, self.repeat(api::clean_up, 10min), asio::detached);
    asio::co_spawn(
        self.io, self.repeat(api::end_lost_leases, self.config.timeouts.leases), asio::detached);
    asio::co_spawn(self.io, self.repeat(api::watch_sensors, 1s), asio::detached);
    asio::co_spawn(self.io, self.repeat(api::run_schedules, 5s), asio::detached);
    asio::co_spawn(self.io, self.webhooks.run(), asio::detached);
    {
        std::vector<std::jthread> threads;
        for (int i = 1; i < self.config.num_io_threads; ++i)
            threads.emplace_back([&self] { self.io.run(); });
        self.io.run();
    }
    self.pool.join();
    self.transfers.join();
}

void Server::reload_certificate() {
    try {
        implementation_->certificate.reload();
        log_info({{"event", "certificate_read"}});
    } catch (const Error& error) {
        log_warning({{"event", "certificate_kept"}, {"what", error.what()}});
    }
}

void Server::stop() {
    Implementation& self = *implementation_;
    if (self.stopping.exchange(true)) return;
    asio::post(self.acceptor.get_executor(), [&self] {
        self.acceptor.close();
        self.events.stop();
        self.webhooks.stop();
        asio::co_spawn(self.io, self.drain(), asio::detached);
    });
}

}  // namespace divemesh::server
