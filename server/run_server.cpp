#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <optional>
#include <thread>
#include <unistd.h>

#include "api/browser_session.hpp"
#include "api/public_url.hpp"
#include "schemas/error.hpp"
#include "schemas/log.hpp"
#include "server/listen_address.hpp"
#include "server/log.hpp"
#include "server/open_files.hpp"
#include "server/server.hpp"
#include "server/worker_supervisor.hpp"
#include "storage/catalog.hpp"
#include "storage/catalog_url.hpp"

namespace divemesh::server {
namespace {

// Hands a URL that may hold a password to the workers in the environment, because every user of the
// machine can read the arguments of a process.
void hand_on_catalog(const ServerConfig& config) {
    if (storage::is_postgresql_url(config.catalog_url))
        setenv("DIVEMESH_CATALOG", config.catalog_url.c_str(), 1);
}

std::vector<std::string> worker_command(const ServerConfig& config) {
    std::vector<std::string> command = {"/proc/self/exe",
                                        "worker",
                                        "--data",
                                        config.data.string(),
                                        "--blobs",
                                        config.blobs_url,
                                        "--min-free",
                                        std::to_string(config.min_free_bytes)};
    if (!storage::is_postgresql_url(config.catalog_url))
        command.insert(command.end(), {"--catalog", config.catalog_url});
    return command;
}

// Calls `stop` on a thread of its own at the first SIGTERM or SIGINT, `reload` at each SIGHUP.
class OnSignal {
public:
    OnSignal(std::function<void()> stop, std::function<void()> reload)
        : stop_(std::move(stop)), reload_(std::move(reload)) {
        wait();
        thread_ = std::jthread([this] { context_.run(); });
    }
    ~OnSignal() { context_.stop(); }
    OnSignal(const OnSignal&) = delete;
    OnSignal& operator=(const OnSignal&) = delete;

private:
    void wait() {
        signals_.async_wait([this](const boost::system::error_code& error, int signal) {
            if (error) return;
            if (signal != SIGHUP) return stop_();
            reload_();
            wait();
        });
    }

    std::function<void()> stop_;
    std::function<void()> reload_;
    boost::asio::io_context context_;
    boost::asio::signal_set signals_{context_, SIGTERM, SIGINT, SIGHUP};
    std::jthread thread_;
};

// Logs are kept and copied, so the token itself stays in its file.
void say_where_token_is(const Server& server) {
    if (server.first_token().empty()) return;
    log_info({{"event", "first_admin_token"},
              {"file", (server.config().data / "admin.token").string()}});
}

// Says what works differently than an operator may expect.
void warn_of(const Server& server) {
    const ServerConfig& config = server.config();
    api::ServiceLimits limits;
    limits.public_url = api::checked_public_url(config.public_url);
    if (api::has_prefix(limits))
        log_warning({{"event", "page_not_under_prefix"},
                     {"what",
                      "--public-url has a path: the API, the command line and sharing links work "
                      "there, the web page does not: give the server a host name of its own"}});
    if (config.tls_certificate.empty() && config.trusted_proxies.empty() &&
        !parse_listen_address(config.listen).address().is_loopback())
        log_warning({{"event", "no_tls"},
                     {"what",
                      "tokens and recordings cross the network as plain text: give --tls-cert and "
                      "--tls-key, or put a proxy before the server (--trusted-proxy)"}});
}

// Says how to open the page, to a person at a terminal only: what is not a terminal may be a log.
void say_how_to_sign_in(const Server& server) {
    if (isatty(STDOUT_FILENO) == 0) return;
    std::string path = "/";
    if (!server.config().no_auth) {
        try {
            const storage::Catalog catalog(server.config().catalog_url);
            path = api::make_sign_in_path(catalog, "", "serve");
        } catch (const Error& error) {
            std::cout << "no link to sign in: " << error.what() << std::endl;
            return;
        }
    }
    std::cout << "open " << server.url() << path
              << (server.config().no_auth ? "" : "\n(signs in once, within 15 minutes)")
              << std::endl;
}

}  // namespace

void run_server(const ServerConfig& config) {
    check_config(config);
    std::signal(SIGXFSZ, SIG_IGN);  // a file that cannot grow becomes an error of write()
    start_log();
    hand_on_catalog(config);  // before there are threads
    ServerConfig fitting = config;
    fitting.max_connections = raise_open_files(config.max_connections);
    Server server(fitting);
    std::optional<WorkerSupervisor> workers;
    if (config.num_workers > 0)
        workers.emplace(worker_command(server.config()), config.num_workers);
    const OnSignal on_signal(
        [&] {
            if (workers) workers->stop();
            server.stop();
        },
        [&] { server.reload_certificate(); });
    say_where_token_is(server);
    warn_of(server);
    std::cout << "listening on " << server.url() << std::endl;
    say_how_to_sign_in(server);
    server.run();
}

}  // namespace divemesh::server
