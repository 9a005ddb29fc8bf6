#include "api/webhook_target.hpp"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <cctype>

#include "api/target.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

namespace ip = boost::asio::ip;

constexpr std::size_t kMaxUrlBytes = 2048;

[[noreturn]] void refuse(const std::string& why) {
    throw Error(ErrorCode::InvalidArgument, "\"url\" " + why + ": give https://host/path");
}

bool is_name(const std::string& host) {
    const auto letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
    const auto plain = [&](char c) {
        return letter(c) || std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '-' ||
               c == '.';
    };
    // Some resolvers read a last part that begins with a digit as a number: octal, hex, 32 bits.
    const std::string last = host.substr(host.rfind('.') + 1);
    return host.size() <= 253 && std::all_of(host.begin(), host.end(), plain) && !last.empty() &&
           letter(last.front());
}

bool is_address(const std::string& host) {
    boost::system::error_code failure;
    const auto address = ip::make_address(host, failure);
    return !failure && address.to_string() == host;
}

struct Block {
    const char* network;
    int prefix_bits;
};

constexpr Block kSpecialV4[] = {{"0.0.0.0", 8},
                                {"10.0.0.0", 8},
                                {"100.64.0.0", 10},
                                {"127.0.0.0", 8},
                                {"169.254.0.0", 16},
                                {"172.16.0.0", 12},
                                {"192.0.0.0", 24},
                                {"192.0.2.0", 24},
                                {"192.88.99.0", 24},
                                {"192.168.0.0", 16},
                                {"198.18.0.0", 15},
                                {"198.51.100.0", 24},
                                {"203.0.113.0", 24},
                                {"224.0.0.0", 3}};
// Special blocks within 2000::/3, the only unicast that is routed: protocols, documentation,
// embedded IPv4.
constexpr Block kSpecialV6[] = {{"2001::", 23}, {"2001:db8::", 32}, {"2002::", 16}, {"3fff::", 20}};

std::vector<unsigned char> bytes_of(const ip::address& address) {
    if (address.is_v4()) {
        const auto bytes = address.to_v4().to_bytes();
        return {bytes.begin(), bytes.end()};
    }
    const auto bytes = address.to_v6().to_bytes();
    return {bytes.begin(), bytes.end()};
}

bool starts_alike(const std::vector<unsigned char>& a,
                  const std::vector<unsigned char>& b,
                  int num_bits) {
    if (a.size() != b.size()) return false;
    for (int bit = 0; bit < num_bits; ++bit) {
        const auto mask = 0x80 >> (bit % 8);
        if ((a[static_cast<std::size_t>(bit / 8)] & mask) !=
            (b[static_cast<std::size_t>(bit / 8)] & mask))
            return false;
    }
    return true;
}

bool is_in(const ip::address& address, const Block& block) {
    return starts_alike(
        bytes_of(address), bytes_of(ip::make_address(block.network)), block.prefix_bits);
}

}  // namespace

WebhookTarget parse_webhook_url(const std::string& url) {
    if (url.size() > kMaxUrlBytes) refuse("is longer than 2048 bytes");
    if (std::any_of(url.begin(), url.end(), [](char c) { return c <= ' ' || c > '~'; }))
        refuse("contains a space or another character that is not allowed");
    WebhookTarget target;
    target.tls = url.starts_with("https://");
    if (!target.tls && !url.starts_with("http://")) refuse("has another scheme");
    const std::string rest = url.substr(url.find("://") + 3);
    const std::string authority = rest.substr(0, rest.find_first_of("/?#\\"));
    target.path = rest.substr(authority.size());
    if (target.path.empty()) target.path += '/';
    if (!target.path.starts_with('/') || target.path.find_first_of("#\\") != std::string::npos)
        refuse("has something other than a path after its host");
    if (authority.find('@') != std::string::npos) refuse("has a user name");
    const bool v6 = authority.starts_with('[');
    const auto host_end = v6 ? authority.find(']') : authority.find(':');
    target.host = v6 ? authority.substr(1, host_end - 1) : authority.substr(0, host_end);
    std::string port =
        host_end == std::string::npos ? "" : authority.substr(host_end + (v6 ? 1 : 0));
    if (v6 ? !is_address(target.host) || host_end == std::string::npos
           : !is_name(target.host) && !is_address(target.host))
        refuse("has no valid host");
    const auto number = port.empty() ? std::optional<std::int64_t>(target.tls ? 443 : 80)
                                     : parse_count(std::string_view(port).substr(1));
    if ((!port.empty() && port.front() != ':') || !number || *number > 65535 ||
        (*number != 80 && *number != 443 && *number < 1024))
        refuse("has a port below 1024 that is neither 80 nor 443");
    target.port = std::to_string(*number);
    return target;
}

AllowedNetworks::AllowedNetworks(const std::vector<std::string>& networks) {
    for (const std::string& text : networks) {
        const auto slash = text.find('/');
        boost::system::error_code failure;
        const auto address = ip::make_address(text.substr(0, slash), failure);
        const int longest = !failure && address.is_v6() ? 128 : 32;
        const auto bits = slash == std::string::npos
                              ? std::optional<std::int64_t>(longest)
                              : parse_count(std::string_view(text).substr(slash + 1));
        if (failure || !bits || *bits > longest)
            throw Error(ErrorCode::InvalidArgument,
                        "\"" + text + "\" is not a network: give e.g. 10.1.0.0/16 or 127.0.0.1");
        networks_.push_back({bytes_of(address), static_cast<int>(*bits)});
    }
}

bool AllowedNetworks::contains(const ip::address& address) const {
    const auto bytes = bytes_of(address);
    return std::any_of(networks_.begin(), networks_.end(), [&](const Network& network) {
        return starts_alike(bytes, network.bytes, network.prefix_bits);
    });
}

bool is_public(const ip::address& address) {
    const auto holds = [&](const Block& block) { return is_in(address, block); };
    if (address.is_v4()) return std::none_of(std::begin(kSpecialV4), std::end(kSpecialV4), holds);
    return is_in(address, {"2000::", 3}) &&
           std::none_of(std::begin(kSpecialV6), std::end(kSpecialV6), holds);
}

}  // namespace divemesh::api
