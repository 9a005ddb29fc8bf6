#pragma once

#include <string>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Returns the address by which clients reach this server, without a slash at its end. Throws
// Error{InvalidArgument} unless it is http(s)://host[:port][/prefix].
std::string checked_public_url(std::string url);

// Returns the origin of that address as browsers write it (RFC 6454): in lower case, without the
// scheme's usual port; "" if the address is not stated.
std::string public_origin(const ServiceLimits& limits);

// Returns whether clients reach this server under a path of another one.
bool has_prefix(const ServiceLimits& limits);

// Returns the address that clients use for a path of this server; the path if that is not stated.
std::string public_address(const ServiceLimits& limits, const std::string& path);

// Makes the addresses in Location and Link those that clients use.
void publish_addresses(const ServiceLimits& limits, Response& response);

}  // namespace divemesh::api
