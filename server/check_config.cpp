#include <filesystem>
#include <unistd.h>

#include "api/public_url.hpp"
#include "api/webhook_target.hpp"
#include "schemas/error.hpp"
#include "server/listen_address.hpp"
#include "server/server.hpp"
#include "server/tls.hpp"

namespace divemesh::server {
namespace {

void check_origin(const std::string& origin) {
    const auto host = origin.find("://");
    const bool plain = (origin.starts_with("https://") || origin.starts_with("http://")) &&
                       origin.size() > host + 3 &&
                       origin.find_first_of("/ *;,", host + 3) == std::string::npos;
    if (!plain)
        throw Error(
            ErrorCode::InvalidArgument,
            "\"" + origin + "\" is not an origin: give e.g. https://lab.example, without a path");
}

void check_folder(const std::filesystem::path& data) {
    const auto folder = data.empty() ? std::filesystem::current_path() : data;
    if (std::filesystem::exists(folder) && access(folder.c_str(), R_OK | W_OK | X_OK) != 0)
        throw Error(ErrorCode::InvalidArgument,
                    "cannot write into " + folder.string() +
                        ": choose another --data folder or change its rights");
}

}  // namespace

void check_config(const ServerConfig& config) {
    const auto endpoint = parse_listen_address(config.listen);
    if (config.no_auth && !endpoint.address().is_loopback())
        throw Error(ErrorCode::InvalidArgument,
                    "--no-auth is only for loopback addresses, not for " + config.listen +
                        ": leave it out or change --listen");
    // These are made only for what their constructors refuse.
    static_cast<void>(TlsCertificate(config.tls_certificate, config.tls_key));
    static_cast<void>(api::AllowedNetworks(config.webhook_networks));
    static_cast<void>(api::AllowedNetworks(config.many_client_networks));
    static_cast<void>(api::AllowedNetworks(config.trusted_proxies));
    api::checked_public_url(config.public_url);
    if (config.hsts.count() > 0 && config.tls_certificate.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "--hsts-days is only for TLS: give --tls-cert and --tls-key, or leave it out");
    for (const std::string& origin : config.allowed_origins) check_origin(origin);
    for (const std::string& origin : config.frame_ancestors)
        if (origin != "'self'") check_origin(origin);
    check_folder(config.data);
}

}  // namespace divemesh::server
