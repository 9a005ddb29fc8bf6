#include "server/forwarded.hpp"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "api/field_values.hpp"

namespace divemesh::server {
namespace {

using Address = boost::asio::ip::address;

// One hop, as the proxy behind it saw it.
struct Hop {
    std::string address;  // with a port perhaps
    std::string protocol;
};

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

// Reads one element of Forwarded: for=192.0.2.1;proto=https or for="[2001:db8::1]:4711".
Hop parse_hop(std::string_view element) {
    Hop hop;
    while (!element.empty()) {
        const auto end = std::min(element.find(';'), element.size());
        const auto pair = element.substr(0, end);
        element.remove_prefix(std::min(end + 1, element.size()));
        const auto equals = pair.find('=');
        if (equals == std::string_view::npos) continue;
        auto value = trimmed(pair.substr(equals + 1));
        if (value.size() >= 2 && value.front() == '"' && value.back() == '"')
            value = value.substr(1, value.size() - 2);
        const auto name = trimmed(pair.substr(0, equals));
        if (name == "for") hop.address = value;
        if (name == "proto") hop.protocol = value;
    }
    return hop;
}

std::vector<Hop> hops_of(const api::Request& request) {
    std::vector<Hop> hops;
    for (auto& address : api::list_elements(request.header("x-forwarded-for")))
        hops.push_back({std::move(address), ""});
    // Proxies that set X-Forwarded-For pass Forwarded on as their client made it up.
    if (hops.empty())
        for (const auto& element : api::list_elements(request.header("forwarded")))
            hops.push_back(parse_hop(element));
    const auto protocols = api::list_elements(request.header("x-forwarded-proto"));
    if (!hops.empty() && !protocols.empty()) hops.back().protocol = protocols.back();
    return hops;
}

// Returns the address without its port: 192.0.2.1:4711, [2001:db8::1]:4711, 2001:db8::1. "unknown"
// and made-up names are none.
std::optional<Address> parse_address(std::string_view text) {
    if (text.starts_with('['))
        text = text.substr(1, text.find(']') - 1);
    else if (text.find(':') == text.rfind(':'))
        text = text.substr(0, text.find(':'));
    boost::system::error_code invalid;
    const Address address = boost::asio::ip::make_address(std::string(text), invalid);
    if (invalid) return std::nullopt;
    return address;
}

}  // namespace

void believe_proxies(api::Request& request, const api::AllowedNetworks& trusted) {
    auto peer = parse_address(request.peer);
    if (!peer || !trusted.contains(*peer)) return;
    const auto hops = hops_of(request);
    for (auto hop = hops.rbegin(); hop != hops.rend() && trusted.contains(*peer); ++hop) {
        const auto client = parse_address(hop->address);
        if (!client) break;
        peer = client;
        if (!hop->protocol.empty()) request.is_https = hop->protocol == "https";
    }
    request.peer = peer->to_string();
}

}  // namespace divemesh::server
