#pragma once

#include "api/http.hpp"
#include "api/webhook_target.hpp"

namespace divemesh::server {

// Sets who the client of a request is, and whether it uses TLS, to what a trusted proxy states:
// Forwarded (RFC 7239), or else X-Forwarded-For and X-Forwarded-Proto. Of a chain of proxies it
// believes the trusted ones at its end, so what a client makes up counts for nothing.
void believe_proxies(api::Request& request, const api::AllowedNetworks& trusted);

}  // namespace divemesh::server
