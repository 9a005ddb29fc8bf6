#pragma once

#include <boost/beast/http/status.hpp>
#include <optional>
#include <string>

#include "server/request_body.hpp"

namespace divemesh::server {

// Why a request is refused before anything of its body is read.
struct HeadFault {
    boost::beast::http::status status;
    std::string detail;
};

// Checks the header fields that say where a request ends (RFC 9112, 6) and to which host it goes
// (RFC 9112, 3.2), which the parser takes more loosely. Returns nullopt for a request that may be
// served. After a fault the connection must be closed, because the server and a proxy before it may
// see different ends of the request.
std::optional<HeadFault> find_head_fault(const RequestBody& request);

}  // namespace divemesh::server
