#pragma once

#include <string>

namespace divemesh::api::client {

// http[s]://host[:port][/base]. The default port is 80, or 443 with TLS.
struct ServerAddress {
    std::string host;
    std::string port;
    std::string base_path;  // "" or "/prefix"
    bool tls = false;
    std::string ca_file = {};  // PEM file with certificates to trust besides the system's

    std::string authority() const;  // host:port, as in a Host header
    std::string url() const;
};
ServerAddress parse_server_url(const std::string& url);  // throws Error{InvalidArgument}

}  // namespace divemesh::api::client
