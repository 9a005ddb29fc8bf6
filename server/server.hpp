#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace divemesh::server {

// How long a connection may keep us waiting.
struct Timeouts {
    std::chrono::milliseconds header = std::chrono::seconds(60);  // the next request, whole header
    std::chrono::milliseconds body = std::chrono::seconds(60);    // between two pieces of a body
    std::chrono::milliseconds rate = std::chrono::seconds(60);    // a body's, to be judged by it
    std::chrono::milliseconds write = std::chrono::seconds(60);   // of one piece of an answer
    std::chrono::milliseconds web_socket = std::chrono::seconds(30);    // without a sign of life
    std::chrono::milliseconds stop = std::chrono::seconds(8);           // for a graceful end
    std::chrono::milliseconds sweep = std::chrono::seconds(60);         // between two sweeps
    std::chrono::milliseconds leases = std::chrono::seconds(5);         // between two looks at them
    std::chrono::milliseconds pending_dives = std::chrono::minutes(1);  // between two attempts
};

struct ServerConfig {
    std::string listen = "127.0.0.1:8080";  // host:port, [::1]:port; port 0: any free one
    std::filesystem::path data;             // default place of catalog, blobs and admin.token
    std::string catalog_url;                // "": sqlite in `data`
    std::string blobs_url;                  // "": blobs/ in `data`
    int num_io_threads = 2;
    int num_blocking_threads = 8;           // for SQL, disk and hashing
    int num_workers = 0;                    // processes to start and watch over
    bool no_auth = false;                   // loopback only
    std::filesystem::path tls_certificate;  // chain in PEM; with tls_key, or neither: no TLS
    std::filesystem::path tls_key;
    std::int64_t max_upload_bytes = std::int64_t{1} << 42;
    std::int64_t min_free_bytes = std::int64_t{256} << 20;  // room on the disk that is never used
    std::chrono::milliseconds upload_lifetime = std::chrono::hours(168);  // without a byte
    std::int64_t max_open_uploads = 1000;                                 // of one project
    std::int64_t max_token_uploads = 200;                                 // open ones of one token
    std::int64_t min_upload_bytes_per_s = 64;                             // over Timeouts::rate
    std::int64_t max_project_bytes = 0;  // of its dives and uploads; 0: no limit
    std::int64_t max_project_dives = 0;  // 0: no limit
    int max_connections = 2000;
    std::filesystem::path import_folder;  // whose dives are taken at the start; "": none
    std::string import_project = "default";
    std::string import_preset;                  // of their reconstructions; "": none
    std::vector<std::string> allowed_origins;   // of pages elsewhere that may talk to us (CORS)
    std::vector<std::string> webhook_networks;  // private ones that webhooks may reach
    double max_requests_per_s = 0.0;            // of one token, twice that at once; 0: no limit
    double max_failed_logins_per_s = 5.0;       // of one address, a hundredfold at once
    std::chrono::milliseconds keep_deleted = std::chrono::hours(24 * 30);  // dives
    Timeouts timeouts = {};
};

// Serves the API. The constructor opens catalog, blob store and port, and makes the first token.
// Throws Error{InvalidArgument} for an address that is not one, for no_auth on other addresses than
// loopback, and for a catalog without any token there; Error{Unavailable} when the port is taken.
class Server {
public:
    explicit Server(ServerConfig config);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    std::string url() const;                 // http://127.0.0.1:8080, with the port that was found
    const std::string& first_token() const;  // the secret made just now; "": there was one before
    const ServerConfig& config() const;      // with the defaults filled in

    void run();   // until stop(); returns when every upload is flushed and every connection closed
    void stop();  // from any thread
    // Reads the certificate anew for connections from now on, or logs why not. From any thread.
    void reload_certificate();

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

// `divemesh serve`: a Server with its workers until SIGTERM or SIGINT. Prints one line on stdout
// once it is ready: "listening on http://127.0.0.1:8080". Same errors as Server's constructor.
void run_server(const ServerConfig& config);

// Whether a server could be started with it, as far as that shows without touching anything. Same
// errors as Server's constructor.
void check_config(const ServerConfig& config);

}  // namespace divemesh::server
