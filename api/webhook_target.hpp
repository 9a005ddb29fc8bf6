#pragma once

#include <boost/asio/ip/address.hpp>
#include <string>
#include <vector>

namespace divemesh::api {

// Where a webhook is sent to.
struct WebhookTarget {
    bool tls = true;
    std::string host;  // a name, or an address without brackets
    std::string port;
    std::string path;  // with its query
};

// Throws Error{InvalidArgument} for what is no plain http(s) address: user names, odd ports, hosts
// that are numbers in another form than dotted decimals, blanks and control characters.
WebhookTarget parse_webhook_url(const std::string& url);

// Networks of our own that webhooks may reach, "127.0.0.1/32" or "10.1.0.0/16". Throws
// Error{InvalidArgument}.
class AllowedNetworks {
public:
    AllowedNetworks() = default;
    explicit AllowedNetworks(const std::vector<std::string>& networks);
    bool contains(const boost::asio::ip::address& address) const;

private:
    struct Network {
        std::vector<unsigned char> bytes;
        int prefix_bits = 0;
    };
    std::vector<Network> networks_;
};

// Not of this machine, of a private or local network, or otherwise special (IANA's registries of
// special-purpose addresses, RFC 6890).
bool is_public(const boost::asio::ip::address& address);

}  // namespace divemesh::api
