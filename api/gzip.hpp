#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "api/http.hpp"

namespace divemesh::api {

// Returns the bytes in the gzip format (RFC 1952).
std::string gzip(std::string_view bytes);

// Returns the bytes of a file in the gzip format, made in constant memory.
std::unique_ptr<BodySource> gzip_source(FilePart file);

}  // namespace divemesh::api
