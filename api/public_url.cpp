#include "api/public_url.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

std::size_t prefix_at(const std::string& url) {
    const auto scheme = url.find("://");
    return scheme == std::string::npos ? scheme : url.find('/', scheme + 3);
}

}  // namespace

std::string checked_public_url(std::string url) {
    if (url.empty()) return url;
    const auto refuse = [&url](const std::string& why) {
        throw Error(
            ErrorCode::InvalidArgument,
            "--public-url " + url + " " + why + ": give https://host or https://host/prefix");
    };
    const auto scheme = url.find("://");
    const auto name = url.substr(0, scheme);
    if (scheme == std::string::npos || (name != "http" && name != "https"))
        refuse("does not begin with http:// or https://");
    while (url.ends_with('/')) url.pop_back();
    const auto rest = std::string_view(url).substr(std::min(scheme + 3, url.size()));
    if (rest.empty() || rest.starts_with('/') || rest.starts_with(':')) refuse("has no host name");
    const auto is_odd = [](unsigned char c) { return c <= ' ' || c >= 0x7f; };
    if (rest.find_first_of("?#@<>\"\\") != std::string_view::npos ||
        std::any_of(rest.begin(), rest.end(), is_odd))
        refuse("has more than a host and a path");
    return url;
}

bool has_prefix(const ServiceLimits& limits) {
    return prefix_at(limits.public_url) != std::string::npos;
}

std::string public_origin(const ServiceLimits& limits) {
    std::string origin = limits.public_url.substr(0, prefix_at(limits.public_url));
    if (origin.empty()) return "";
    for (char& c : origin) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    const std::string usual_port = origin.starts_with("https:") ? ":443" : ":80";
    if (origin.ends_with(usual_port)) origin.resize(origin.size() - usual_port.size());
    return origin;
}

std::string public_address(const ServiceLimits& limits, const std::string& path) {
    return limits.public_url + path;
}

void publish_addresses(const ServiceLimits& limits, Response& response) {
    if (limits.public_url.empty()) return;
    for (auto& [name, value] : response.headers) {
        if (name == "Location" && value.starts_with('/')) value.insert(0, limits.public_url);
        if (name == "Link" && value.starts_with("</")) value.insert(1, limits.public_url);
    }
}

}  // namespace divemesh::api
