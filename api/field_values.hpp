#pragma once

#include <string>
#include <string_view>
#include <vector>

// Values of HTTP header fields, as RFC 9110 writes them.
namespace divemesh::api {

// Returns the elements of a list, in lower case, without the empty ones (RFC 9110, 5.6.1).
std::vector<std::string> list_elements(std::string_view field);

// Returns the media type in lower case, without its parameters (RFC 9110, 8.3.1).
std::string media_type_of(std::string_view field);

}  // namespace divemesh::api
