#include "api/client/server_address.hpp"

#include <algorithm>

#include "schemas/error.hpp"

namespace divemesh::api::client {
namespace {

constexpr std::string_view kScheme = "http://";
constexpr std::string_view kTlsScheme = "https://";

}  // namespace

ServerAddress parse_server_url(const std::string& url) {
    const auto refuse = [&](const std::string& why) {
        throw Error(
            ErrorCode::InvalidArgument,
            "server address " + url + " " + why + ": give http://host:port or https://host:port");
    };
    const bool tls = url.starts_with(kTlsScheme);
    if (!tls && !url.starts_with(kScheme)) refuse("does not begin with http:// or https://");
    const std::string rest = url.substr(tls ? kTlsScheme.size() : kScheme.size());
    const std::size_t slash = std::min(rest.find('/'), rest.size());
    std::string authority = rest.substr(0, slash);
    ServerAddress server{"", tls ? "443" : "80", rest.substr(slash), tls};
    while (server.base_path.ends_with('/')) server.base_path.pop_back();
    const std::size_t colon = authority.rfind(':');
    if (colon != std::string::npos && authority.find(']', colon) == std::string::npos) {
        server.port = authority.substr(colon + 1);
        authority.resize(colon);
    }
    if (authority.starts_with('[') && authority.ends_with(']'))
        authority = authority.substr(1, authority.size() - 2);
    server.host = authority;
    if (server.host.empty() || server.host.find_first_of(" @?#") != std::string::npos)
        refuse("has no host name");
    if (server.port.empty() || server.port.find_first_not_of("0123456789") != std::string::npos)
        refuse("has a port that is not a number");
    return server;
}

std::string ServerAddress::authority() const {
    const bool is_ipv6 = host.find(':') != std::string::npos;
    return (is_ipv6 ? "[" + host + "]" : host) + ":" + port;
}

std::string ServerAddress::url() const {
    return std::string(tls ? kTlsScheme : kScheme) + authority() + base_path;
}

}  // namespace divemesh::api::client
