#pragma once

#include <boost/asio/ip/address.hpp>
#include <string>
#include <vector>

namespace divemesh::api {

// The address that a webhook is sent to.
struct WebhookTarget {
    bool tls = true;
    std::string host;  // a name, or an address without brackets
    std::string port;
    std::string path;  // with its query
};

// Parses a webhook's URL. Throws Error{InvalidArgument} unless it is a plain http(s) address: no
// user names, odd ports, hosts that are numbers in another form than dotted decimals, blanks or
// control characters.
WebhookTarget parse_webhook_url(const std::string& url);

// Private networks that webhooks may reach, e.g. "127.0.0.1/32" or "10.1.0.0/16". Throws
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

// Returns whether an address is public: not of this machine, not of a private or local network, and
// not otherwise special (IANA's registries of special-purpose addresses, RFC 6890).
bool is_public(const boost::asio::ip::address& address);

}  // namespace divemesh::api
