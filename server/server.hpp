#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "api/page_file.hpp"

namespace divemesh::server {

// How long a connection may keep the server waiting.
struct Timeouts {
    std::chrono::milliseconds header = std::chrono::seconds(60);      // of the next request, whole
    std::chrono::milliseconds body = std::chrono::seconds(60);        // between two parts of a body
    std::chrono::milliseconds rate = std::chrono::seconds(60);        // to measure a body's rate
    std::chrono::milliseconds write = std::chrono::seconds(60);       // of one part of a response
    std::chrono::milliseconds web_socket = std::chrono::seconds(30);  // without a sign of life
    std::chrono::milliseconds stop = std::chrono::seconds(8);         // for a graceful end
    std::chrono::milliseconds sweep = std::chrono::seconds(60);       // between two sweeps
    std::chrono::milliseconds leases = std::chrono::seconds(5);       // between two checks
    std::chrono::milliseconds pending_dives = std::chrono::minutes(1);  // between two attempts
};

// The configuration of a server, as `divemesh serve` takes it.
struct ServerConfig {
    std::string listen = "127.0.0.1:8080";  // host:port, [::1]:port; port 0: any free one
    std::filesystem::path data;             // default place of catalog, blobs and admin.token
    std::string catalog_url;                // "": sqlite in `data`
    std::string blobs_url;                  // "": blobs/ in `data`
    int num_io_threads = 2;
    int num_blocking_threads = 8;           // for SQL, disk and hashing
    int num_transfer_threads = 4;           // each turns one upload at a time into a blob
    int num_workers = 0;                    // processes to start and supervise
    bool no_auth = false;                   // loopback only
    std::filesystem::path tls_certificate;  // PEM chain, with tls_key; both empty: no TLS
    std::filesystem::path tls_key;
    std::chrono::seconds hsts{0};  // Strict-Transport-Security (RFC 6797), with TLS; 0: none
    std::int64_t max_upload_bytes = std::int64_t{1} << 42;
    std::int64_t min_free_bytes = std::int64_t{256} << 20;  // disk space that is never used
    // Gives up what can be computed again until the disk has so many bytes free, or does nothing if
    // that is not enough; may be empty.
    std::function<void(std::int64_t)> make_room = {};
    std::chrono::milliseconds upload_lifetime = std::chrono::hours(168);  // without a byte
    std::int64_t max_open_uploads = 1000;                                 // of one project
    std::int64_t max_token_uploads = 200;      // open uploads of one token
    std::int64_t min_upload_bytes_per_s = 64;  // over Timeouts::rate
    std::int64_t max_project_bytes = 0;        // of its dives, results and uploads; 0: none
    std::int64_t max_project_dives = 0;        // 0: no limit
    int max_connections = 2000;                // a quarter of them for clients with a valid token
    int max_address_connections = 256;         // of one address; 0: no limit
    // Networks whose addresses stand for many clients each, such as a reverse proxy's: no limit per
    // address.
    std::vector<std::string> many_client_networks;
    // Proxies that are believed who their client is; each stands for many clients.
    std::vector<std::string> trusted_proxies;
    std::string public_url;  // that clients use, e.g. https://lab.example/dives; "": not stated
    std::filesystem::path import_folder;  // whose dives are imported at the start; "": no import
    std::string import_project = "default";
    std::string import_preset;                  // of their reconstructions; "": no reconstruction
    std::vector<std::string> allowed_origins;   // of other pages that may use the server (CORS)
    std::vector<std::string> frame_ancestors;   // of pages that may show /embed in a frame
    std::vector<std::string> webhook_networks;  // private networks that webhooks may reach
    double max_requests_per_s = 0.0;            // of one token, twice that in a burst; 0: no limit
    double max_failed_logins_per_s = 5.0;       // of one address, a hundred times that in a burst
    // How long deleted dives can be restored before they are removed.
    std::chrono::milliseconds keep_deleted = std::chrono::hours(24 * 30);
    std::chrono::milliseconds keep_lost_workers = std::chrono::minutes(10);  // in their list
    std::span<const api::PageFile> page = {};  // the web page; empty: none
    Timeouts timeouts = {};
};

// Serves the API. The constructor opens catalog, blob store and port, and creates the first token.
// Throws Error{InvalidArgument} for an invalid address, and, on addresses other than loopback, for
// no_auth and for a catalog without a token; Error{Conflict} if catalog and blobs do not belong
// together; Error{Unavailable} if the port is in use.
class Server {
public:
    explicit Server(ServerConfig config);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    std::string url() const;                 // http://127.0.0.1:8080, with the actual port
    const std::string& first_token() const;  // if created now; "": there was a token
    const ServerConfig& config() const;      // with the defaults filled in

    void run();   // until stop(); returns when every upload is flushed and every connection closed
    void stop();  // from any thread
    // Reads the certificate again for new connections; logs a failure. Call it from any thread.
    void reload_certificate();

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

// Runs `divemesh serve`: a Server with its workers until SIGTERM or SIGINT. Prints one line on
// stdout once it is ready: "listening on http://127.0.0.1:8080"; on a terminal also a link that
// opens the page signed in. Throws as check_config() and Server's constructor do.
void run_server(const ServerConfig& config);

// Checks whether a server could start with `config`, as far as possible without changing anything.
// Throws as Server's constructor does.
void check_config(const ServerConfig& config);

}  // namespace divemesh::server
