#include "tests/storage/s3_server.hpp"

#include <arpa/inet.h>
#include <csignal>
#include <cstdlib>
#include <netinet/in.h>
#include <stdexcept>
#include <sys/socket.h>
#include <utility>

#include "schemas/file_descriptor.hpp"
#include "storage/s3_client.hpp"
#include "tests/paths.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

sockaddr_in loopback(int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
}

bool takes_connections(int port) {
    const FileDescriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    const sockaddr_in address = loopback(port);
    return connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

bool is_installed(const std::string& program) { return fs::exists("/usr/bin/" + program); }

}  // namespace

int free_port() {
    const FileDescriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof address;
    auto* plain = reinterpret_cast<sockaddr*>(&address);
    if (bind(socket.get(), plain, size) != 0 || getsockname(socket.get(), plain, &size) != 0)
        throw std::runtime_error("no free port");
    return ntohs(address.sin_port);
}

// Also for the programs that a test starts: no proxy reaches this machine's loopback.
S3Server::S3Server(S3Credentials credentials)
    : credentials_(std::move(credentials)), port_(free_port()) {
    setenv("no_proxy", "127.0.0.1", 1);
    unsetenv("AWS_CA_BUNDLE");
}

std::unique_ptr<S3Server> S3Server::start_s3rver() {
    const fs::path program =
        source_directory() / "tests/end_to_end/js/node_modules/s3rver/bin/s3rver.js";
    if (!fs::exists(program)) return nullptr;
    std::unique_ptr<S3Server> server(new S3Server({"S3RVER", "S3RVER", ""}));
    server->start({"/usr/bin/env",
                   "node",
                   program.string(),
                   "--directory",
                   (server->folder_ / "data").string(),
                   "--address",
                   "127.0.0.1",
                   "--port",
                   std::to_string(server->port_),
                   "--no-vhost-buckets",
                   "--silent"});
    server->make_bucket();
    return server;
}

std::unique_ptr<S3Server> S3Server::start_ceph(int num_gibibytes) {
    for (const char* program : {"ceph-mon", "ceph-osd", "radosgw", "radosgw-admin"})
        if (!is_installed(program)) return nullptr;
    std::unique_ptr<S3Server> server(new S3Server({"divemesh", "divemesh-secret", ""}));
    server->start({"/usr/bin/setpriv",
                   "--pdeathsig",
                   "TERM",
                   (source_directory() / "tests/storage/ceph_s3.sh").string(),
                   (server->folder_ / "data").string(),
                   std::to_string(server->port_),
                   std::to_string(free_port()),
                   server->credentials_.access_key,
                   server->credentials_.secret_key,
                   std::to_string(num_gibibytes)});
    const bool is_ready = wait_until(
        120s, [&] { return server->process_->stdout_text().find("ready") != std::string::npos; });
    if (!is_ready) throw std::runtime_error("Ceph: " + server->process_->stderr_text());
    server->make_bucket();
    return server;
}

S3Server* S3Server::shared_ceph() {
    static const std::unique_ptr<S3Server> kServer = start_ceph();
    return kServer.get();
}

S3Server::~S3Server() {
    if (!process_) return;
    process_->send(SIGTERM);
    process_->wait(30s);
}

void S3Server::start(const std::vector<std::string>& command) {
    fs::create_directories(folder_ / "data");
    process_.emplace(command, folder_.path());
    const bool is_up = wait_until(
        120s, [&] { return takes_connections(port_) || process_->wait(0s).has_value(); });
    if (!is_up || process_->wait(0s))
        throw std::runtime_error("no object store: " + process_->stderr_text());
}

void S3Server::make_bucket() const { S3Client(parse_s3_url(url("")), credentials_).put("", {}); }

std::string S3Server::url(const std::string& prefix, int port) const {
    return "s3://dives" + (prefix.empty() ? "" : '/' + prefix) +
           "?endpoint=http://127.0.0.1:" + std::to_string(port == 0 ? port_ : port);
}

}  // namespace divemesh::storage
